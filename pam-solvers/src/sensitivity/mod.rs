//! Gradients of losses of a solution.

mod continuous;
mod discrete_adjoint;
mod finite_difference;
mod forward;
mod gradient;
mod loss;
mod observations;
mod problem;
mod tolerance_halving;

pub use continuous::{Backsolve, InterpolatingAdjoint, QuadratureAdjoint};
pub use discrete_adjoint::{AdjointWorkspace, Checkpointing, DiscreteAdjoint};
pub use finite_difference::FiniteDifference;
pub use forward::{ForwardSensitivity, Sensitivities};
pub use gradient::{Gradient, GradientMethod, GradientStatistics};
pub use loss::Loss;
pub use problem::Problem;
pub use tolerance_halving::{ToleranceHalving, tolerance_halving};
