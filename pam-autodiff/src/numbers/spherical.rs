//! Spherical Bessel functions without cancellation near zero.
//!
//! The closed forms lose all digits for small arguments; below [`SERIES_BELOW`] the power series
//! `j_n(x)/xⁿ = Σ_k (−x²/2)^k / (k! (2n+2k+1)!!)` is summed instead.

use pam_core::Scalar;

const SERIES_BELOW: f64 = 1.0;

/// Terms of the series; the last one is below 1e-17 of the first at `x = 1`.
const TERMS: usize = 9;

/// `j_n(x) / xⁿ` by its series.
fn series<S: Scalar>(n: usize, x: S) -> S {
    let factor = (x * x).scaled(-0.5);
    // The ratio of term k to term k − 1 is −x²/2 / (k (2n + 2k + 1)).
    let mut sum = S::one();
    for k in (1..TERMS).rev() {
        sum = S::one() + (factor * sum).scaled(1.0 / (k * (2 * n + 2 * k + 1)) as f64);
    }
    let double_factorial: usize = (1..=n).map(|k| 2 * k + 1).product();
    sum.scaled(1.0 / double_factorial as f64)
}

/// `j₀(x) = sin x / x`.
pub(crate) fn j0<S: Scalar>(x: S) -> S {
    if x.real().abs() < SERIES_BELOW { series(0, x) } else { x.sin() / x }
}

/// `j₁(x) / x = (sin x − x cos x) / x³`.
pub(crate) fn j1_over_x<S: Scalar>(x: S) -> S {
    if x.real().abs() < SERIES_BELOW {
        series(1, x)
    } else {
        let (sin, cos) = x.sin_cos();
        (sin / x - cos) / (x * x)
    }
}

/// `j₂(x) / x² = (3 j₁(x)/x − j₀(x)) / x²`.
pub(crate) fn j2_over_x2<S: Scalar>(x: S) -> S {
    if x.real().abs() < SERIES_BELOW {
        series(2, x)
    } else {
        (j1_over_x(x).scaled(3.0) - j0(x)) / (x * x)
    }
}
