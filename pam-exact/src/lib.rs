//! Exact simulation.
mod adjoint;
mod atlas;
mod cell;
mod event;
mod forcing;
mod fundamental;
mod gradient;
mod motion;
mod network;
mod solve;

pub use cell::Window;
pub use forcing::ForceSignal;
pub use gradient::{ExactProblem, ExactSolver};
pub use motion::ExactMotion;
pub use network::{PiecewiseNetwork, Plane};
pub use solve::ExactStatistics;
