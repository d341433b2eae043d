//! Step-size controllers.

mod constant;
mod pid;
mod tolerances;

pub use constant::ConstantStep;
pub use pid::PidController;
pub use tolerances::Tolerances;

use std::sync::Arc;

/// Verdict of a controller on a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    /// The step is accepted.
    pub accept: bool,
    /// Ratio of the next step to the present one.
    pub factor: f64,
}

/// Chooses step sizes. The controller sees real parts only, so plain and dual runs take the same
/// steps.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not control steps",
    label = "a step controller is needed here",
    note = "use `PidController::new(rtol, atol)` or `ConstantStep::new(step_s)`"
)]
pub trait StepController: Send + Sync {
    /// The first step to try (s), or `None` to have it estimated from the field.
    fn initial_step_s(&self) -> Option<f64>;

    /// The largest step allowed, s.
    fn largest_step_s(&self) -> f64 {
        f64::INFINITY
    }

    /// The tolerances against which the error is measured, or `None` for steps without control.
    fn tolerances(&self) -> Option<&Tolerances>;

    /// Judges a step by its error in units of the tolerance. `history` holds the errors of the last
    /// two accepted steps, the latest first, 1 where there is none; `order` is the exponent of the
    /// step in the error estimate.
    fn decide(&self, error: f64, history: [f64; 2], order: usize) -> Decision;
}

/// A controller that is chosen at run time.
impl StepController for Arc<dyn StepController> {
    fn initial_step_s(&self) -> Option<f64> {
        self.as_ref().initial_step_s()
    }
    fn largest_step_s(&self) -> f64 {
        self.as_ref().largest_step_s()
    }
    fn tolerances(&self) -> Option<&Tolerances> {
        self.as_ref().tolerances()
    }
    fn decide(&self, error: f64, history: [f64; 2], order: usize) -> Decision {
        self.as_ref().decide(error, history, order)
    }
}
