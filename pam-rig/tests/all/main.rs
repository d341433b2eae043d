//! The rig: its parts, its protocols, what its sensors log, the physics that every joint obeys, and what each hidden effect
//! does.

mod common;
mod effects {
    mod mechanics {
        mod hysteresis;
    }
    mod spec;
}
/// Every effect does what the vocabulary says: with its number, its unit and its sign, on truth and log.
mod hidden {
    mod expressions;
    mod gas;
    mod mechanics;
    mod pairs;
    mod sensing;
    mod timed;
    mod unlisted;
    mod vocabulary;
}
mod observables;
/// The plant obeys what every joint obeys: balances, inequalities, limits and orders of convergence.
mod physics {
    mod convergence;
    mod energy;
    mod gas;
    mod newton;
    mod slack;
    mod sticking;
}
mod plant {
    mod braid;
    mod friction;
    mod gas;
    mod losses;
    mod wall;
}
mod pneumatics {
    mod servo;
    mod supply;
    mod valve;
}
mod protocol {
    mod builtin;
    mod conditions;
    mod current;
    mod read;
}
mod repeat;
mod rig;
mod sensors;
mod servo;
