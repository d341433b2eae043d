//! Normal equations of a few unknowns.

use pam_numerics::{ScaledCholesky, SquareMatrix};

/// `Jᵀ W J`, and `Jᵀ W r` block by block.
pub(super) struct Normal {
    pub(super) gram: SquareMatrix,
    pub(super) blocks: Vec<Vec<f64>>,
}

impl Normal {
    pub(super) fn zeros(unknowns: usize) -> Self {
        Self { gram: SquareMatrix::zeros(unknowns), blocks: Vec::new() }
    }

    pub(super) fn add(&mut self, other: Normal) {
        self.gram += &other.gram;
        self.blocks.extend(other.blocks);
    }

    pub(super) fn right(&self) -> Vec<f64> {
        let mut sum = vec![0.0; self.gram.size()];
        for block in &self.blocks {
            sum.iter_mut().zip(block).for_each(|(s, b)| *s += b);
        }
        sum
    }

    /// Solves `(G + damping·diag G) x = b` for each right-hand side, on a unit diagonal: unknowns differ by
    /// orders of magnitude. None if the equations are singular.
    pub(super) fn solve(&self, damping: f64, rights: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
        let factor = ScaledCholesky::new(self.gram.size(), |i, j| self.gram[(i, j)], damping)?;
        rights.iter().map(|right| factor.solve(right)).collect()
    }

    /// Standard errors that hold whatever the correlation of residuals inside a block (Liang and Zeger
    /// 1986): the root of the diagonal of `G⁻¹ (Σ_b g_b g_bᵀ) G⁻¹ · B/(B−1)`. Infinite where the data do
    /// not determine an unknown.
    pub(super) fn standard_errors(&self) -> Vec<f64> {
        let blocks = self.blocks.len() as f64;
        match self.solve(0.0, &self.blocks) {
            None => vec![f64::INFINITY; self.gram.size()],
            Some(influences) => (0..self.gram.size())
                .map(|i| {
                    let sum: f64 = influences.iter().map(|x| x[i] * x[i]).sum();
                    let determined = self.gram[(i, i)] > 0.0;
                    let variance = sum * blocks / (blocks - 1.0).max(1.0);
                    if determined { variance.sqrt() } else { f64::INFINITY }
                })
                .collect(),
        }
    }
}
