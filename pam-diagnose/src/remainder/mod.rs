//! A smooth correction that is learned through the simulation.

mod basis;
mod ground;
mod learn;

pub(crate) use ground::{Dyn, Ground};
pub use learn::Learned;
pub(crate) use learn::learn;
