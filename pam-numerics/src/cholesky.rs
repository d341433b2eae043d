//! Cholesky factorisation of a matrix that is first scaled to a unit diagonal.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};

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
pub struct ScaledCholesky {
    factor: Llt<f64>,
    scale: Vec<f64>,
}

impl ScaledCholesky {
    /// Factorises the `n × n` matrix with the entries `entry(row, column)`, of which the lower triangle is
    /// read. `ridge` is the `ρ` of the equation above: the damping of Levenberg and Marquardt, or a ridge
    /// relative to the diagonal. `None` if the matrix is not positive definite.
    #[must_use]
    pub fn new(n: usize, entry: impl Fn(usize, usize) -> f64, ridge: f64) -> Option<Self> {
        let scale: Vec<f64> = (0..n)
            .map(|i| match entry(i, i) {
                0.0 => 1.0,
                diagonal => diagonal.sqrt().recip(),
            })
            .collect();
        if !scale.iter().all(|s| s.is_finite()) {
            return None;
        }
        let scaled = Mat::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => 1.0 + ridge,
            std::cmp::Ordering::Greater => entry(i, j) * scale[i] * scale[j],
        });
        Some(Self { factor: scaled.llt(Side::Lower).ok()?, scale })
    }

    /// The solution `x` of `(A + ρ diag(A)) x = right`; `None` if it is not finite.
    #[must_use]
    pub fn solve(&self, right: &[f64]) -> Option<Vec<f64>> {
        let mut x = Mat::from_fn(self.scale.len(), 1, |i, _| right[i] * self.scale[i]);
        self.factor.solve_in_place(&mut x);
        let x: Vec<f64> = self.scale.iter().enumerate().map(|(i, s)| x[(i, 0)] * s).collect();
        x.iter().all(|v| v.is_finite()).then_some(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The Hilbert matrix of order 4 with its integer inverse, rows and columns scaled over 12 decades.
    #[test]
    fn badly_scaled_unknowns_are_solved() {
        let size = [1e-6, 1.0, 1e3, 1e6];
        let a = |i: usize, j: usize| size[i] * size[j] / (i + j + 1) as f64;
        let factor = ScaledCholesky::new(4, a, 0.0).unwrap();
        let inverse = [16.0, -120.0, 240.0, -140.0];
        let x = factor.solve(&[size[0], 0.0, 0.0, 0.0]).unwrap();
        for i in 0..4 {
            assert!((x[i] * size[i] / inverse[i] - 1.0).abs() < 1e-10, "{i}: {}", x[i]);
        }
    }

    #[test]
    fn a_ridge_is_relative_to_the_diagonal() {
        let factor = ScaledCholesky::new(2, |i, j| if i == j { 1e8 } else { 0.0 }, 0.25).unwrap();
        let x = factor.solve(&[1e8, 5e8]).unwrap();
        assert!((x[0] - 0.8).abs() < 1e-14 && (x[1] - 4.0).abs() < 1e-14);
    }

    #[test]
    fn unknowns_without_influence_stay_at_zero_and_indefinite_matrices_are_refused() {
        let a = [[2.0, 0.0], [0.0, 0.0]];
        let x = ScaledCholesky::new(2, |i, j| a[i][j], 0.0).unwrap().solve(&[4.0, 0.0]).unwrap();
        assert!((x[0] - 2.0).abs() < 1e-15 && x[1] == 0.0);
        let a = [[1.0, 2.0], [2.0, 1.0]];
        assert!(ScaledCholesky::new(2, |i, j| a[i][j], 0.0).is_none());
        assert!(ScaledCholesky::new(1, |_, _| f64::NAN, 0.0).is_none());
        assert!(ScaledCholesky::new(1, |_, _| -1.0, 0.0).is_none());
    }
}
