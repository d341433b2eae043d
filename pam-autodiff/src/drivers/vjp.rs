use super::{Function, Recorder};

/// The product from the left `wᵀ J` `[n]` of the Jacobian with a cotangent `w` `[m]`, by a tape: some
/// ten evaluations whatever `n` and `m`.
///
/// # Panics
/// If `w` is not as long as the output.
///
/// ```
/// use pam_autodiff::{Function, vjp};
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
/// assert_eq!(vjp(&Polar, &[2.0, 0.0], &[1.0, 10.0]), [1.0, 20.0]);
/// ```
pub fn vjp(f: &impl Function, x: &[f64], w: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; x.len()];
    vjp_into(f, x, w, &mut product, &mut Recorder::new());
    product
}

/// Writes the [`vjp`].
///
/// # Panics
/// If the lengths do not fit.
///
/// ```
/// use pam_autodiff::{Function, Recorder, vjp_into};
/// use pam_core::Scalar;
/// struct Twice;
/// impl Function for Twice {
///     fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
///         out[0] = x[0].scaled(2.0);
///     }
/// }
/// let mut product = [0.0];
/// vjp_into(&Twice, &[1.0], &[3.0], &mut product, &mut Recorder::new());
/// assert_eq!(product, [6.0]);
/// ```
pub fn vjp_into(f: &impl Function, x: &[f64], w: &[f64], product: &mut [f64], work: &mut Recorder) {
    assert_eq!(w.len(), f.output_len(), "one cotangent for each output");
    work.record(|x, out| f.eval(x, out), x.iter().copied(), w.len());
    let (adjoints, x) = work.reverse(w.iter().copied());
    product.fill(0.0);
    adjoints.add_to(x, product);
}
