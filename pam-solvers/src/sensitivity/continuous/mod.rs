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
use crate::input::Input;
use crate::integrator::Integrator;
use backward::Forward;
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

fn reversed_input<'a, F, I: Input<f64>>(
    problem: &Problem<'a, F, I>,
    forward: &Forward,
) -> ReversedInput<'a, I> {
    ReversedInput::new(problem.input, &forward.grid, &problem.integrator.stops_s)
}

fn method_name<C: StepController>(kind: &str, how: &str, backward: &Integrator<C>) -> String {
    format!("{kind}, {how}, {}", backward.tableau().name)
}
