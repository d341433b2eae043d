use super::function::require_one_output;
use super::{Function, Point};
use num_dual::HyperDual64;

/// The Hessian `∂²f/∂x_i∂x_j` `[n, n]`, row by row, of a function with one output, by one evaluation with
/// hyper-dual numbers for each entry on and above the diagonal. Source: J. Fike and J. Alonso, *The
/// Development of Hyper-Dual Numbers for Exact Second-Derivative Calculations* (2011).
///
/// For many variables take [`hessian_vector`](super::hessian_vector) column by column.
///
/// # Panics
/// If `f` has not one output.
///
/// ```
/// use pam_autodiff::{Function, hessian};
/// use pam_core::Scalar;
/// struct Product;
/// impl Function for Product {
///     fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
///         out[0] = x[0] * x[1] * x[1];
///     }
/// }
/// assert_eq!(hessian(&Product, &[2.0, 3.0]), [0.0, 6.0, 6.0, 4.0]);
/// ```
pub fn hessian(f: &impl Function, x: &[f64]) -> Vec<f64> {
    require_one_output(f);
    let n = x.len();
    let (mut hessian, mut point) = (vec![0.0; n * n], Point::new());
    for i in 0..n {
        for j in i..n {
            let seeded = x.iter().enumerate().map(|(k, &value)| {
                HyperDual64::new(value, f64::from(k == i), f64::from(k == j), 0.0)
            });
            let out = point.eval(|x, out| f.eval(x, out), seeded, 1);
            hessian[i * n + j] = out[0].eps1eps2;
            hessian[j * n + i] = out[0].eps1eps2;
        }
    }
    hessian
}
