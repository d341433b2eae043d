//! The Runge–Kutta method of the steps, as arrays.

use pam_solvers::Tableau;

/// Stages that make a step, without the one at its end.
pub(crate) const STAGES: usize = 6;

/// Tsitouras' method of fifth order with its interpolant ([`Tableau::tsit5`]).
#[derive(Debug, Clone)]
pub(crate) struct Method {
    pub(crate) c: [f64; STAGES],
    pub(crate) a: [[f64; STAGES]; STAGES],
    pub(crate) b: [f64; STAGES],
    pub(crate) error: [f64; STAGES + 1],
    /// Coefficients of the interpolation weights: of θ for each stage, of θ², of θ³ and of θ⁴.
    interpolant: [[f64; STAGES + 1]; 4],
}

impl Method {
    pub(crate) fn new() -> Self {
        let t = Tableau::tsit5();
        let error = t.error.as_deref().unwrap_or_default();
        let at = |row: &[f64], k: usize| row.get(k).copied().unwrap_or(0.0);
        Self {
            c: std::array::from_fn(|i| t.c[i]),
            a: std::array::from_fn(|i| std::array::from_fn(|j| at(&t.a[i], j))),
            b: std::array::from_fn(|i| t.b[i]),
            error: std::array::from_fn(|i| at(error, i)),
            interpolant: std::array::from_fn(|k| std::array::from_fn(|i| at(&t.interpolant[i], k))),
        }
    }

    /// The interpolation weights at a share of the step.
    #[inline(always)]
    pub(crate) fn weights(&self, theta: f64) -> [f64; STAGES + 1] {
        // By powers across stages: each line is a vector operation.
        let mut weights = self.interpolant[3];
        for row in self.interpolant[..3].iter().rev() {
            for (weight, row) in weights.iter_mut().zip(row) {
                *weight = *weight * theta + row;
            }
        }
        for weight in &mut weights {
            *weight *= theta;
        }
        weights
    }
}
