//! The plant obeys what every joint obeys: balances, inequalities, limits and orders of convergence.

#[path = "../common/mod.rs"]
mod common;
mod convergence;
mod energy;
mod gas;
mod newton;
mod slack;
mod sticking;
