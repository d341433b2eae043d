use super::{Loss, Problem};
use crate::error::SolveError;
use crate::grid::Grid;
use crate::solution::Statistics;

/// Value and gradient of a loss, with what was computed on the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    /// The loss.
    pub value: f64,
    /// Its gradient with respect to the parameters of the field, in their order.
    pub parameters: Vec<f64>,
    /// Its gradient with respect to the initial state.
    pub initial_state: Vec<f64>,
    /// Its gradient with respect to the parameters of the input, in their order.
    pub input: Vec<f64>,
    /// The observed states, row-major `[times, states]`.
    pub states: Vec<f64>,
    /// The accepted steps.
    pub grid: Grid,
    /// Cost.
    pub statistics: GradientStatistics,
}

/// Counts of a gradient.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GradientStatistics {
    /// Accepted steps of the forward solve.
    pub steps: usize,
    /// Rejected steps of the forward solve.
    pub rejected: usize,
    /// Steps taken again to recover what was not stored, or to differentiate the frozen grid.
    pub replayed: usize,
    /// Accepted steps of backward solves.
    pub backward_steps: usize,
    /// Rejected steps of backward solves.
    pub backward_rejected: usize,
    /// Evaluations of the vector field in plain numbers.
    pub evaluations: usize,
    /// Products of a cotangent with the field's Jacobians.
    pub vjps: usize,
    /// Products of the field's Jacobians with a tangent.
    pub jvps: usize,
    /// Peak memory for stored states and stages, bytes.
    pub checkpoint_bytes: usize,
}

impl GradientStatistics {
    pub(super) fn of_forward(forward: Statistics) -> Self {
        Self {
            steps: forward.accepted,
            rejected: forward.rejected,
            evaluations: forward.evaluations,
            ..Self::default()
        }
    }
}

/// A way to obtain the gradient of a loss of a solution.
#[diagnostic::on_unimplemented(
    message = "`{Self}` finds no gradients for the field `{F}` under the input `{I}`",
    label = "a gradient method is needed here",
    note = "take one of `pam_solvers::sensitivity`, for example `DiscreteAdjoint::new(ByTape)`; the field must \
            implement `ParametricField` and the input `ParametricInput`"
)]
pub trait GradientMethod<F, I> {
    /// Name for tables and figures, the differentiation included.
    fn name(&self) -> String;

    /// Solves `problem`, evaluates `loss` on the observed states, and returns value and gradient with
    /// respect to the parameters of the field, the initial state and the parameters of the input.
    ///
    /// # Errors
    /// [`SolveError`] if the request is inconsistent or a solve stops early.
    fn value_and_gradient(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Gradient, Box<SolveError<f64>>>;

    /// The method without its type, to stand in one list with others.
    fn boxed(self) -> AnyGradientMethod<F, I>
    where
        Self: Sized + Send + Sync + 'static,
    {
        Box::new(self)
    }
}

/// A gradient method that is chosen at run time, for a field `F` under an input `I`.
/// [`GradientChoice::method`](super::GradientChoice::method) makes one from a name.
pub type AnyGradientMethod<F, I> = Box<dyn GradientMethod<F, I> + Send + Sync>;

impl<F, I, M: GradientMethod<F, I> + ?Sized> GradientMethod<F, I> for Box<M> {
    fn name(&self) -> String {
        (**self).name()
    }

    fn value_and_gradient(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        (**self).value_and_gradient(problem, loss)
    }
}
