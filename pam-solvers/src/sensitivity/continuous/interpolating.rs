use super::backward::Forward;
use super::{backward_or_forward, method_name, with_sums};
use crate::controller::{PidController, StepController};
use crate::error::SolveError;
use crate::input::ParametricInput;
use crate::integrator::Integrator;
use crate::sensitivity::{Gradient, GradientMethod, Loss, MethodSetup, NamedMethod, Problem};
use pam_autodiff::{ByTape, Differentiation};
use pam_core::ParametricField;

/// Continuous adjoint that reads the state from the dense forward solution.
///
/// The backward state is `[λ, μ]`: adjoint, and the sums that become the gradient. Nothing explodes that
/// does not explode forward; memory is that of the dense solution. The gradient is that of the exact
/// solution up to both tolerances and the interpolant's error, not that of the computed one.
///
/// Source: as in SciMLSensitivity's `InterpolatingAdjoint` (C. Rackauckas and others, *Universal
/// Differential Equations for Scientific Machine Learning*, 2020).
#[derive(Debug, Clone)]
pub struct InterpolatingAdjoint<D, C = PidController> {
    /// How the field is differentiated.
    pub differentiation: D,
    /// Method and step control of the backward solve; those of the problem if absent. Its error norm runs over adjoint and sums.
    pub backward: Option<Integrator<C>>,
}

impl<D> InterpolatingAdjoint<D> {
    /// The adjoint by `differentiation`; the way back is solved with method and step control of the problem.
    pub fn new(differentiation: D) -> Self {
        Self { differentiation, backward: None }
    }
}

impl<D, C> InterpolatingAdjoint<D, C> {
    /// The same with a method and step control of its own for the way back.
    #[must_use]
    pub fn with_backward<B>(self, backward: Integrator<B>) -> InterpolatingAdjoint<D, B> {
        let Self { differentiation, .. } = self;
        InterpolatingAdjoint { differentiation, backward: Some(backward) }
    }
}

impl<C> NamedMethod<C> for InterpolatingAdjoint<ByTape, C> {
    fn from_setup(setup: MethodSetup<C>) -> Self {
        InterpolatingAdjoint::new(ByTape).with_backward(setup.integrator)
    }
}

impl<F, I, D, C> GradientMethod<F, I> for InterpolatingAdjoint<D, C>
where
    F: ParametricField,
    I: ParametricInput,
    D: Differentiation<F>,
    C: StepController,
{
    fn name(&self) -> String {
        method_name("interpolating adjoint", self.differentiation.name(), self.backward.as_ref())
    }

    fn value_and_gradient(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        let forward = Forward::new(problem, loss, true)?;
        let field = self.differentiation.of(problem.field);
        with_sums(problem, forward, field, backward_or_forward(&self.backward, problem), false)
    }
}
