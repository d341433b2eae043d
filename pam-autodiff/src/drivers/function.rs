use pam_core::Scalar;

/// A function `ℝⁿ → ℝᵐ`, written once for every scalar.
///
/// ```
/// use pam_autodiff::{Function, gradient, hessian};
/// use pam_core::Scalar;
///
/// /// `(1 − x)² + 100 (y − x²)²`
/// struct Rosenbrock;
///
/// impl Function for Rosenbrock {
///     fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
///         let (a, b) = (S::constant(1.0) - x[0], x[1] - x[0] * x[0]);
///         out[0] = a * a + (b * b).scaled(100.0);
///     }
/// }
///
/// assert_eq!(gradient(&Rosenbrock, &[1.0, 1.0]), [0.0, 0.0]);
/// assert_eq!(hessian(&Rosenbrock, &[1.0, 1.0]), [802.0, -400.0, -400.0, 200.0]);
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no function over any scalar",
    note = "implement `Function` with `fn eval<S: Scalar>(&self, x: &[S], out: &mut [S])`; a closure goes to \
            `gradient_of(|x: &[Var]| …, at)`"
)]
pub trait Function {
    /// Number of outputs m.
    fn output_len(&self) -> usize {
        1
    }

    /// Writes `f(x)` to `out`, which has [`output_len`](Self::output_len) entries.
    fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]);
}

impl<F: Function + ?Sized> Function for &F {
    fn output_len(&self) -> usize {
        (**self).output_len()
    }
    fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
        (**self).eval(x, out);
    }
}

/// The panic of a driver for scalar functions.
pub(super) fn require_one_output(f: &impl Function) {
    assert_eq!(f.output_len(), 1, "a gradient or Hessian is of a function with one output");
}
