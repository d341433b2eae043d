use super::function::require_one_output;
use super::{Function, Recorder};
use crate::tape::Var;

/// The gradient `∂f/∂x` `[n]` of a function with one output, by a tape: some ten evaluations whatever
/// `n`.
///
/// # Panics
/// If `f` has not one output.
///
/// ```
/// use pam_autodiff::{Function, gradient};
/// use pam_core::Scalar;
/// struct Product;
/// impl Function for Product {
///     fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
///         out[0] = x.iter().copied().product();
///     }
/// }
/// assert_eq!(gradient(&Product, &[2.0, 3.0, 5.0]), [15.0, 10.0, 6.0]);
/// ```
pub fn gradient(f: &impl Function, x: &[f64]) -> Vec<f64> {
    let mut gradient = vec![0.0; x.len()];
    gradient_into(f, x, &mut gradient, &mut Recorder::new());
    gradient
}

/// [`gradient`] of a closure.
///
/// ```
/// use num_dual::DualNum;
/// use pam_autodiff::{Var, gradient_of};
/// let g = gradient_of(|x: &[Var]| x[0] * x[1].exp(), &[2.0, 0.0]);
/// assert_eq!(g, [1.0, 2.0]);
/// ```
pub fn gradient_of(f: impl FnOnce(&[Var]) -> Var, x: &[f64]) -> Vec<f64> {
    let mut gradient = vec![0.0; x.len()];
    write(|x, out| out[0] = f(x), x, &mut gradient, &mut Recorder::new());
    gradient
}

/// Writes the [`gradient`] and returns `f(x)`.
///
/// # Panics
/// If `f` has not one output, or `gradient` is not as long as `x`.
///
/// ```
/// use pam_autodiff::{Function, Recorder, gradient_into};
/// use pam_core::Scalar;
/// struct Square;
/// impl Function for Square {
///     fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
///         out[0] = x[0] * x[0];
///     }
/// }
/// let (mut gradient, mut work) = ([0.0], Recorder::new());
/// for x in [1.0, 2.0, 3.0] {
///     assert_eq!(gradient_into(&Square, &[x], &mut gradient, &mut work), x * x);
///     assert_eq!(gradient, [2.0 * x]);
/// }
/// ```
pub fn gradient_into(
    f: &impl Function,
    x: &[f64],
    gradient: &mut [f64],
    work: &mut Recorder,
) -> f64 {
    require_one_output(f);
    write(|x, out| f.eval(x, out), x, gradient, work)
}

fn write(
    f: impl FnOnce(&[Var], &mut [Var]),
    x: &[f64],
    gradient: &mut [f64],
    work: &mut Recorder,
) -> f64 {
    work.record(f, x.iter().copied(), 1);
    let value = work.values().sum();
    let (adjoints, x) = work.reverse([1.0].into_iter());
    gradient.fill(0.0);
    adjoints.add_to(x, gradient);
    value
}
