//! Continuous adjoints: differentiate, then discretise.
//!
//! The adjoint equation is solved backwards in `s = −t`. The adjoint jumps at observations; backward steps
//! end where the input jumps, and at the stops of the forward solve.

mod adjoint_field;
mod backsolve;
mod backward;
mod gauss;
mod interpolating;
mod quadrature;
mod reversed;

pub use backsolve::Backsolve;
pub use interpolating::InterpolatingAdjoint;
pub use quadrature::QuadratureAdjoint;

use super::{Gradient, Problem};
use crate::controller::StepController;
use crate::error::SolveError;
use crate::input::{Input, ParametricInput};
use crate::integrator::Integrator;
use crate::save_at::SaveAt;
use crate::term::Term;
use adjoint_field::AdjointField;
use backward::{Forward, solve_backward};
use pam_autodiff::DifferentiableField;
use pam_core::ParametricField;
use reversed::ReversedInput;

/// The gradient from the adjoint at the start and the sums over field and input parameters.
fn gradient(forward: Forward, lambda: &[f64], sums: &[f64], [p, q]: [usize; 2]) -> Gradient {
    Gradient {
        value: forward.value,
        parameters: sums[..p].to_vec(),
        initial_state: lambda.to_vec(),
        input: sums[p..p + q].to_vec(),
        states: forward.observed.into_states(),
        grid: forward.grid,
        statistics: forward.statistics,
    }
}

/// The gradient with its sums integrated along with the adjoint.
fn with_sums<F: ParametricField, I: ParametricInput>(
    problem: &Problem<'_, F, I>,
    mut forward: Forward,
    field: impl DifferentiableField,
    backward: &Integrator<dyn StepController + '_>,
    restart: bool,
) -> Result<Gradient, Box<SolveError<f64>>> {
    let dense = forward.dense.take();
    let adjoint = AdjointField::new(field, problem.input, dense.as_ref(), true);
    let term = Term::new(&adjoint, reversed_input(problem, &forward));
    let end = SaveAt::End;
    let z = solve_backward(problem, backward, &mut forward, &term, restart, end, &mut |_| {})?;
    let (lambda, sums) = z[adjoint.lambda()..].split_at(problem.y0.len());
    Ok(gradient(forward, lambda, sums, adjoint.parameter_lens()))
}

/// The backward solver: an integrator of its own, or that of the problem. Behind one type, so that the backward solve
/// is instantiated once for all step controllers.
fn backward_or_forward<'a, F, I, C: StepController + 'a>(
    backward: &'a Option<Integrator<C>>,
    problem: &Problem<'a, F, I>,
) -> &'a Integrator<dyn StepController + 'a> {
    match backward {
        Some(own) => own,
        None => problem.integrator,
    }
}

fn reversed_input<'a, F, I: Input<f64>>(
    problem: &Problem<'a, F, I>,
    forward: &Forward,
) -> ReversedInput<'a, I> {
    ReversedInput::new(problem.input, &forward.grid, &problem.integrator.stops_s)
}

fn method_name<C: StepController>(
    kind: &str,
    how: &str,
    backward: Option<&Integrator<C>>,
) -> String {
    match backward {
        Some(backward) => format!("{kind}, {how}, {}", backward.tableau().name),
        None => format!("{kind}, {how}"),
    }
}
