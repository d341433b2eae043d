//! Gradients of losses of a solution.

mod discrete_adjoint;
mod forward;
mod gradient;
mod loss;
mod observations;
mod problem;

pub use discrete_adjoint::{AdjointWorkspace, Checkpointing, DiscreteAdjoint};
pub use forward::{ForwardSensitivity, Sensitivities};
pub use gradient::{Gradient, GradientMethod, GradientStatistics};
pub use loss::Loss;
pub use problem::Problem;
