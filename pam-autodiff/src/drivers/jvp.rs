use super::{Function, Point};
use num_dual::Dual64;

/// The product from the right `J v` `[m]` of the Jacobian with a direction `v` `[n]`, by one evaluation
/// with dual numbers.
///
/// # Panics
/// If `v` is not as long as `x`.
///
/// ```
/// use pam_autodiff::{Function, jvp};
/// use pam_core::Scalar;
/// struct Polar;
/// impl Function for Polar {
///     fn output_len(&self) -> usize {
///         2
///     }
///     fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
///         let (sin, cos) = x[1].sin_cos();
///         (out[0], out[1]) = (x[0] * cos, x[0] * sin);
///     }
/// }
/// assert_eq!(jvp(&Polar, &[2.0, 0.0], &[1.0, 10.0]), [1.0, 20.0]);
/// ```
pub fn jvp(f: &impl Function, x: &[f64], v: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; f.output_len()];
    jvp_into(f, x, v, &mut product, &mut Point::new());
    product
}

/// Writes the [`jvp`].
///
/// # Panics
/// If the lengths do not fit.
///
/// ```
/// use pam_autodiff::{Function, Point, jvp_into};
/// use pam_core::Scalar;
/// struct Twice;
/// impl Function for Twice {
///     fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
///         out[0] = x[0].scaled(2.0);
///     }
/// }
/// let mut product = [0.0];
/// jvp_into(&Twice, &[1.0], &[3.0], &mut product, &mut Point::new());
/// assert_eq!(product, [6.0]);
/// ```
pub fn jvp_into(
    f: &impl Function,
    x: &[f64],
    v: &[f64],
    product: &mut [f64],
    work: &mut Point<Dual64>,
) {
    assert_eq!(product.len(), f.output_len(), "one entry for each output");
    assert_eq!(v.len(), x.len(), "one change for each input");
    let x = x.iter().zip(v).map(|(&x, &v)| Dual64::new(x, v));
    let out = work.eval(|x, out| f.eval(x, out), x, product.len());
    for (product, out) in product.iter_mut().zip(out) {
        *product = out.eps;
    }
}
