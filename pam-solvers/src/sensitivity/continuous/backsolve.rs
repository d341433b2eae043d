use super::backward::Forward;
use super::{backward_or_forward, method_name, with_sums};
use crate::controller::{PidController, StepController};
use crate::error::SolveError;
use crate::input::ParametricInput;
use crate::integrator::Integrator;
use crate::sensitivity::{Gradient, GradientMethod, Loss, MethodSetup, NamedMethod, Problem};
use pam_autodiff::{ByTape, Differentiation};
use pam_core::ParametricField;

/// Continuous adjoint with the state integrated back together with it, in constant memory.
///
/// The backward state is `[y, λ, μ]`: state, adjoint, and the sums that become the gradient. Going back,
/// a dissipative motion is an exploding one: on a stiff problem the recovered state, and with it the
/// gradient, is wrong long before the backward solve fails. Use it only where the state can be trusted,
/// or observe often: at every observation the state is set to the one the forward solve had
/// ([`restart_at_observations`](Self::restart_at_observations), as torchdiffeq does).
///
/// The gradient is that of the exact solution up to both tolerances, not that of the computed one.
///
/// Source: R. T. Q. Chen and others, *Neural Ordinary Differential Equations*, NeurIPS 2018.
#[derive(Debug, Clone)]
pub struct Backsolve<D, C = PidController> {
    /// How the field is differentiated.
    pub differentiation: D,
    /// Method and step control of the backward solve; those of the problem if absent. Its error norm runs over state, adjoint and sums.
    pub backward: Option<Integrator<C>>,
    /// Sets the state to the observed one at every observation; `true` unless changed.
    pub restart_at_observations: bool,
}

impl<D> Backsolve<D> {
    /// The adjoint by `differentiation`; the way back is solved with method and step control of the problem.
    pub fn new(differentiation: D) -> Self {
        Self { differentiation, backward: None, restart_at_observations: true }
    }
}

impl<D, C> Backsolve<D, C> {
    /// The same with a method and step control of its own for the way back.
    #[must_use]
    pub fn with_backward<B>(self, backward: Integrator<B>) -> Backsolve<D, B> {
        let Self { differentiation, .. } = self;
        Backsolve {
            differentiation,
            backward: Some(backward),
            restart_at_observations: self.restart_at_observations,
        }
    }
}

impl<C> NamedMethod<C> for Backsolve<ByTape, C> {
    fn from_setup(setup: MethodSetup<C>) -> Self {
        Backsolve::new(ByTape).with_backward(setup.integrator)
    }
}

impl<F, I, D, C> GradientMethod<F, I> for Backsolve<D, C>
where
    F: ParametricField,
    I: ParametricInput,
    D: Differentiation<F>,
    C: StepController,
{
    fn name(&self) -> String {
        method_name("backsolve adjoint", self.differentiation.name(), self.backward.as_ref())
    }

    fn value_and_gradient(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        let forward = Forward::new(problem, loss, false)?;
        let field = self.differentiation.of(problem.field);
        let backward = backward_or_forward(&self.backward, problem);
        with_sums(problem, forward, field, backward, self.restart_at_observations)
    }
}
