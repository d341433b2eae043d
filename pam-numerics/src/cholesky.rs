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
#[derive(Debug)]
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
        let mut lower = Mat::zeros(n, n);
        for j in 0..n {
            for i in j..n {
                lower[(i, j)] = entry(i, j);
            }
        }
        Self::of_lower(lower, ridge)
    }

    /// Not generic, so that the factorisation is compiled once.
    fn of_lower(mut scaled: Mat<f64>, ridge: f64) -> Option<Self> {
        let n = scaled.nrows();
        let scale: Vec<f64> = (0..n)
            .map(|i| match scaled[(i, i)] {
                0.0 => 1.0,
                diagonal => diagonal.sqrt().recip(),
            })
            .collect();
        if !scale.iter().all(|s| s.is_finite()) {
            return None;
        }
        for j in 0..n {
            scaled[(j, j)] = 1.0 + ridge;
            for i in j + 1..n {
                scaled[(i, j)] = scaled[(i, j)] * scale[i] * scale[j];
            }
        }
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
