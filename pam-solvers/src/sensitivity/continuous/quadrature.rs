use super::adjoint_field::AdjointField;
use super::backward::{Forward, solve_backward};
use super::gauss::gauss_legendre;
use super::{backward_or_forward, gradient, method_name, reversed_input};
use crate::controller::{PidController, StepController};
use crate::error::SolveError;
use crate::input::ParametricInput;
use crate::integrator::Integrator;
use crate::save_at::SaveAt;
use crate::sensitivity::{Gradient, GradientMethod, Loss, MethodSetup, NamedMethod, Problem};
use crate::solution::Solution;
use crate::term::Term;
use pam_autodiff::{ByTape, Differentiation};
use pam_core::ParametricField;

/// Continuous adjoint whose parameter gradient is a quadrature,
///
/// ```text
/// dL/dp = ∫ (∂f/∂p)ᵀ λ dt
/// ```
///
/// by Gauss–Legendre points in every step of the backward solve. Only the adjoint λ is integrated, so the
/// error control is not diluted by thousands of parameters, and the products with the parameters are
/// needed at the points only. State and adjoint are read from dense solutions. The gradient is that of
/// the exact solution up to both tolerances and the interpolants' errors.
///
/// Nothing controls the error of the quadrature. Where the integrand has kinks (a linearly interpolated
/// input has them at its samples when its parameters are differentiated) make these times stops of the
/// forward integrator; backward steps then end there too.
///
/// Source: as in SciMLSensitivity's `QuadratureAdjoint`, with a fixed rule.
#[derive(Debug, Clone)]
pub struct QuadratureAdjoint<D, C = PidController> {
    /// How the field is differentiated.
    pub differentiation: D,
    /// Method and step control of the backward solve; those of the problem if absent. Its error norm runs over the adjoint.
    pub backward: Option<Integrator<C>>,
    /// Gauss–Legendre points in each backward step, at least one; 4 unless changed, exact to degree 7.
    pub points: usize,
}

impl<D> QuadratureAdjoint<D> {
    /// The adjoint by `differentiation` and 4 points a step; the way back is solved with method and step control of the problem.
    pub fn new(differentiation: D) -> Self {
        Self { differentiation, backward: None, points: 4 }
    }
}

impl<D, C> QuadratureAdjoint<D, C> {
    /// The same with a method and step control of its own for the way back.
    #[must_use]
    pub fn with_backward<B>(self, backward: Integrator<B>) -> QuadratureAdjoint<D, B> {
        let Self { differentiation, .. } = self;
        QuadratureAdjoint { differentiation, backward: Some(backward), points: self.points }
    }
}

impl<C> NamedMethod<C> for QuadratureAdjoint<ByTape, C> {
    fn from_setup(setup: MethodSetup<C>) -> Self {
        QuadratureAdjoint::new(ByTape).with_backward(setup.integrator)
    }
}

impl<F, I, D, C> GradientMethod<F, I> for QuadratureAdjoint<D, C>
where
    F: ParametricField,
    I: ParametricInput,
    D: Differentiation<F>,
    C: StepController,
{
    fn name(&self) -> String {
        method_name("quadrature adjoint", self.differentiation.name(), self.backward.as_ref())
    }

    fn value_and_gradient(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        let mut forward = Forward::new(problem, loss, true)?;
        let dense = forward.dense.take();
        let field = self.differentiation.of(problem.field);
        let adjoint = AdjointField::new(field, problem.input, dense.as_ref(), false);
        let term = Term::new(&adjoint, reversed_input(problem, &forward));
        let n = problem.y0.len();
        let rule = gauss_legendre(self.points.max(1));
        let mut sums = vec![0.0; adjoint.parameter_lens().iter().sum()];
        let (mut lambda, mut u) = (vec![0.0; n], vec![0.0; problem.input.input_len()]);
        let mut integrate = |segment: &Solution<f64>| {
            let Some(solution) = &segment.dense else { return };
            for step in solution.grid_s().windows(2) {
                let h = step[1] - step[0];
                for &(x, weight) in &rule {
                    let s = step[0] + x * h;
                    solution.at_into(s, &mut lambda);
                    for l in &mut lambda {
                        *l *= weight * h;
                    }
                    adjoint.add_integrand(-s, &lambda, &mut u, &mut sums);
                }
            }
        };
        let backward = backward_or_forward(&self.backward, problem);
        let dense = SaveAt::Dense;
        let z =
            solve_backward(problem, backward, &mut forward, &term, false, dense, &mut integrate)?;
        Ok(gradient(forward, &z, &sums, adjoint.parameter_lens()))
    }
}
