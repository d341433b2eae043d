//! The rig: its parts, its protocols, and what its sensors log.

#[path = "../common/mod.rs"]
mod common;
mod effects {
    mod mechanics {
        mod hysteresis;
    }
    mod spec;
}
mod observables;
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
