//! Exact simulation.
mod adjoint;
mod atlas;
mod cell;
mod event;
mod forcing;
mod fundamental;
mod gradient;
mod inverse;
mod motion;
mod network;
mod partition;
mod solve;

pub use cell::Window;
pub use forcing::ForceSignal;
pub use gradient::{ExactProblem, ExactSolver};
pub use inverse::{Certificate, InverseProblem, InverseSolution, InverseSolver};
pub use motion::ExactMotion;
pub use network::{PiecewiseNetwork, Plane};
pub use partition::{Partition, Partitioner, Polygon};
pub use solve::ExactStatistics;
