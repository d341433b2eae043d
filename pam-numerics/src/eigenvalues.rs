//! Eigenvalues of a general matrix.

use faer::Mat;

/// Eigenvalues `[real, imaginary]` of an `n × n` row-major matrix; `None` if the iteration does not converge.
///
/// # Panics
/// If the matrix has fewer than `n²` entries.
///
/// ```
/// // A rotation by 90°: ±i.
/// let mut values = pam_numerics::eigenvalues(2, &[0.0, -1.0, 1.0, 0.0]).unwrap();
/// values.sort_by(|a, b| a[1].total_cmp(&b[1]));
/// assert!((values[0][1] + 1.0).abs() < 1e-15 && (values[1][1] - 1.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn eigenvalues(n: usize, rows: &[f64]) -> Option<Vec<[f64; 2]>> {
    let matrix = Mat::from_fn(n, n, |i, j| rows[i * n + j]);
    Some(matrix.eigenvalues().ok()?.iter().map(|value| [value.re, value.im]).collect())
}
