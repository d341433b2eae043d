//! Cholesky factorisation of a matrix that is first scaled to a unit diagonal.
//!
//! The factorisation is the textbook one (Golub and Van Loan, *Matrix Computations*, algorithm 4.2.1), row by row. The normal
//! matrices here have some hundred rows at most, and a linear-algebra library would be most of what a program on a vector
//! field compiles.

use crate::dot::dot;

/// Cholesky factor of a symmetric positive definite matrix `A`, scaled to a unit diagonal.
///
/// ```text
/// A + ρ diag(A) = D⁻¹ L Lᵀ D⁻¹      D = diag(A)^(−1/2)
/// ```
///
/// The scaling matters for normal equations whose unknowns differ by orders of magnitude: it nearly minimises
/// the condition number over all diagonal scalings (van der Sluis 1969). An unknown with a zero diagonal has
/// no influence on the data; its diagonal counts as 1, so a zero right-hand side leaves it at zero.
///
/// ```
/// let a = [[4.0, 2.0], [2.0, 9.0]];
/// let factor = pam_numerics::ScaledCholesky::new(2, |i, j| a[i][j], 0.0).unwrap();
/// let x = factor.solve(&[8.0, 20.0]).unwrap();
/// assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 2.0).abs() < 1e-15);
/// ```
#[derive(Debug)]
pub struct ScaledCholesky {
    /// Row `i` of the factor from `i (i + 1) / 2` on, its diagonal last.
    rows: Vec<f64>,
    scale: Vec<f64>,
}

/// Where a row of a packed lower triangle begins.
fn start(row: usize) -> usize {
    row * (row + 1) / 2
}

impl ScaledCholesky {
    /// Factorises the `n × n` matrix with the entries `entry(row, column)`, of which the lower triangle is
    /// read. `ridge` is the `ρ` of the equation above: the damping of Levenberg and Marquardt, or a ridge
    /// relative to the diagonal. `None` if the matrix is not positive definite.
    #[must_use]
    pub fn new(n: usize, entry: impl Fn(usize, usize) -> f64, ridge: f64) -> Option<Self> {
        let mut lower = Vec::with_capacity(start(n));
        for i in 0..n {
            lower.extend((0..=i).map(|j| entry(i, j)));
        }
        Self::of_lower(n, lower, ridge)
    }

    /// Not generic, so that the factorisation is compiled once.
    fn of_lower(n: usize, mut rows: Vec<f64>, ridge: f64) -> Option<Self> {
        let scale: Vec<f64> = (0..n)
            .map(|i| match rows[start(i) + i] {
                0.0 => 1.0,
                diagonal => diagonal.sqrt().recip(),
            })
            .collect();
        if !scale.iter().all(|s| s.is_finite()) {
            return None;
        }
        for i in 0..n {
            let (before, row) = rows.split_at_mut(start(i));
            for j in 0..i {
                let other = &before[start(j)..];
                let scaled = row[j] * scale[i] * scale[j];
                row[j] = (scaled - dot(&row[..j], other)) / other[j];
            }
            let pivot = 1.0 + ridge - dot(&row[..i], &row[..i]);
            // Written so that NaN is refused as well.
            if !(pivot > 0.0 && pivot.is_finite()) {
                return None;
            }
            row[i] = pivot.sqrt();
        }
        Some(Self { rows, scale })
    }

    /// The solution `x` of `(A + ρ diag(A)) x = right`; `None` if it is not finite.
    #[must_use]
    pub fn solve(&self, right: &[f64]) -> Option<Vec<f64>> {
        let n = self.scale.len();
        let mut x: Vec<f64> = right.iter().zip(&self.scale).map(|(r, s)| r * s).collect();
        for i in 0..n {
            let row = &self.rows[start(i)..=start(i) + i];
            x[i] = (x[i] - dot(&x[..i], row)) / row[i];
        }
        for i in (0..n).rev() {
            let row = &self.rows[start(i)..=start(i) + i];
            x[i] /= row[i];
            let solved = x[i];
            x[..i].iter_mut().zip(row).for_each(|(x, l)| *x -= l * solved);
        }
        x.iter_mut().zip(&self.scale).for_each(|(x, s)| *x *= s);
        x.iter().all(|v| v.is_finite()).then_some(x)
    }
}
