//! Linear least squares of a few unknowns.

use crate::ScaledCholesky;

/// Least squares of one target on a few features with a ridge that is relative to their mean squares;
/// `None` if they are dependent. `rows` yields features with their target.
///
/// ```
/// use pam_numerics::least_squares;
///
/// // y = 2 + 3 x
/// let rows = (0..5).map(|k| f64::from(k)).map(|x| ([1.0, x], 2.0 + 3.0 * x));
/// let [offset, slope] = least_squares(rows, 0.0).expect("independent features");
/// assert!((offset - 2.0).abs() < 1e-9 && (slope - 3.0).abs() < 1e-9);
/// ```
#[must_use]
pub fn least_squares<const N: usize>(
    rows: impl Iterator<Item = ([f64; N], f64)>,
    relative_ridge: f64,
) -> Option<[f64; N]> {
    let mut gram = [[0.0; N]; N];
    let mut right = [0.0; N];
    for (row, y) in rows {
        for i in 0..N {
            for j in 0..N {
                gram[i][j] += row[i] * row[j];
            }
            right[i] += row[i] * y;
        }
    }
    if (0..N).any(|i| gram[i][i] == 0.0) {
        return None;
    }
    let factor = ScaledCholesky::new(N, |i, j| gram[i][j], relative_ridge)?;
    factor.solve(&right)?.try_into().ok()
}
