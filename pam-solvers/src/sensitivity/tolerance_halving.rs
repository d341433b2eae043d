use super::{Gradient, GradientMethod, Loss, Problem};
use crate::controller::PidController;
use crate::error::SolveError;
use crate::integrator::Integrator;

/// A gradient at some tolerance and at half of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ToleranceHalving {
    /// The gradient at the given tolerances.
    pub coarse: Gradient,
    /// The gradient at half of them.
    pub fine: Gradient,
    /// `|L_c − L_f| / |L_f|`, and `‖g_c − g_f‖ / ‖g_f‖` for parameters of the field, initial state and
    /// parameters of the input; 0 where both vanish.
    pub relative_difference: [f64; 4],
}

/// Compares a gradient with the one at half the tolerances, to see if it has converged.
///
/// Error control looks at states. The derivative of a solution can be wrong by any factor while the
/// solution is as accurate as asked, for instance in `u̇ = (t − θ)⁴` past `t = θ`, where steps grow over
/// the place that matters for `∂u/∂θ`. The gradients here are exact for the steps taken, so nothing but
/// other steps shows it: a difference much larger than the tolerance means that the tolerance is too
/// loose *for the gradient*. A small difference is no proof: at a rest point the error vanishes, both
/// tolerances lead to the same long steps, and only a bound on the step helps. `integrator` replaces
/// `problem.integrator`.
///
/// # Errors
/// [`SolveError`] of either gradient.
pub fn tolerance_halving<F, I>(
    method: &dyn GradientMethod<F, I>,
    problem: &Problem<'_, F, I>,
    integrator: &Integrator<PidController>,
    loss: &mut dyn Loss,
) -> Result<ToleranceHalving, Box<SolveError<f64>>> {
    let mut half = integrator.clone();
    half.controller.tolerances = integrator.controller.tolerances.scaled(0.5);
    let coarse = method.value_and_gradient(&Problem { integrator, ..*problem }, loss)?;
    let fine = method.value_and_gradient(&Problem { integrator: &half, ..*problem }, loss)?;
    let relative_difference = [
        relative_difference(&[coarse.value], &[fine.value]),
        relative_difference(&coarse.parameters, &fine.parameters),
        relative_difference(&coarse.initial_state, &fine.initial_state),
        relative_difference(&coarse.input, &fine.input),
    ];
    Ok(ToleranceHalving { coarse, fine, relative_difference })
}

/// `‖a − b‖ / ‖b‖`, 0 where both vanish.
fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    let difference = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    let size = b.iter().map(|b| b * b).sum::<f64>().sqrt();
    if difference == 0.0 { 0.0 } else { difference / size }
}
