use crate::drivers::{Function, Point};
use crate::numbers::ComplexStep;

/// The complex step `Im f(x + ih) / h`; error O(h²) with no cancellation, so `h` can be tiny and the
/// result is exact to rounding.
///
/// It applies to real analytic functions: `f` is evaluated with true complex arithmetic, and branches
/// look at the real part, so at a kink it gives the slope of the branch that is taken. Since it needs
/// `f` at a complex number, it takes functions that are generic over the scalar and is no
/// [`DifferenceScheme`](super::DifferenceScheme). Sources at [`ComplexStep`].
///
/// ```
/// use num_dual::DualNum;
/// use pam_autodiff::ComplexDifference;
/// let slope = ComplexDifference::default().derivative(|x| x.exp() / x, 1.5);
/// let exact = 1.5_f64.exp() * (1.0 / 1.5 - 1.0 / (1.5 * 1.5));
/// assert!((slope - exact).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComplexDifference {
    /// Step h, in units of x.
    pub h: f64,
}

/// `h = 1e-40`: its square is lost against any argument above 1e-30, and products of it are far from
/// underflow.
impl Default for ComplexDifference {
    fn default() -> Self {
        Self { h: 1e-40 }
    }
}

impl ComplexDifference {
    /// Name for tables and plots.
    #[must_use]
    pub fn name(&self) -> &'static str {
        "complex_step"
    }

    /// `f'(x)`.
    pub fn derivative(&self, f: impl FnOnce(&ComplexStep) -> ComplexStep, x: f64) -> f64 {
        f(&ComplexStep::new(x, self.h)).im / self.h
    }

    /// The Jacobian `∂f_i/∂x_j` `[m, n]`, row by row, by one evaluation for each input.
    ///
    /// ```
    /// use pam_autodiff::{ComplexDifference, Function};
    /// use pam_core::Scalar;
    /// struct Product;
    /// impl Function for Product {
    ///     fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
    ///         out[0] = x[0] * x[1];
    ///     }
    /// }
    /// let gradient = ComplexDifference::default().jacobian(&Product, &[2.0, 3.0]);
    /// assert!((gradient[0] - 3.0).abs() < 1e-15 && (gradient[1] - 2.0).abs() < 1e-15);
    /// ```
    pub fn jacobian(&self, f: &impl Function, x: &[f64]) -> Vec<f64> {
        let mut jacobian = vec![0.0; f.output_len() * x.len()];
        let mut point = Point::new();
        for j in 0..x.len() {
            let seeded = x
                .iter()
                .enumerate()
                .map(|(k, &value)| ComplexStep::new(value, if k == j { self.h } else { 0.0 }));
            let out = point.eval(|x, out| f.eval(x, out), seeded, f.output_len());
            for (row, out) in jacobian.chunks_exact_mut(x.len()).zip(out) {
                row[j] = out.im / self.h;
            }
        }
        jacobian
    }
}
