//! Normal equations of a few unknowns, with priors.

use pam_numerics::{ScaledCholesky, SquareMatrix};

/// The unknowns: those that all experiments share, then those of each experiment.
pub(super) struct Unknowns {
    /// One over the variance of the prior of each shared unknown; zero without one.
    pub(super) common: Vec<f64>,
    /// The same for the unknowns of one experiment.
    pub(super) own: Vec<f64>,
    /// Number of experiments.
    pub(super) experiments: usize,
}

impl Unknowns {
    fn len(&self) -> usize {
        self.common.len() + self.own.len() * self.experiments
    }

    /// Place of unknown `k` of an experiment, shared ones first.
    fn place(&self, experiment: usize, k: usize) -> usize {
        let common = self.common.len();
        if k < common { k } else { common + self.own.len() * experiment + (k - common) }
    }

    fn precisions(&self) -> Vec<f64> {
        let own = std::iter::repeat_n(&self.own, self.experiments).flatten();
        self.common.iter().chain(own).copied().collect()
    }

    /// `Σ (deviation / prior deviation)²`.
    pub(super) fn prior_cost(&self, deviations: &[f64]) -> f64 {
        self.precisions().iter().zip(deviations).map(|(p, d)| p * d * d).sum()
    }
}

/// `Jᵀ W J + Σ⁻¹`, and `Jᵀ W r` block by block.
pub(super) struct Normal {
    gram: SquareMatrix,
    pub(super) blocks: Vec<Vec<f64>>,
    prior: Vec<f64>,
}

/// Blocks of one experiment in the clustered covariance.
const BLOCKS: usize = 10;

impl Normal {
    /// Normal equations with the priors alone, at given deviations from their means.
    pub(super) fn new(unknowns: &Unknowns, deviations: &[f64]) -> Self {
        let precisions = unknowns.precisions();
        let mut gram = SquareMatrix::zeros(unknowns.len());
        for (k, precision) in precisions.iter().enumerate() {
            gram[(k, k)] = *precision;
        }
        let prior = precisions.iter().zip(deviations).map(|(p, d)| p * d).collect();
        Self { gram, blocks: Vec::new(), prior }
    }

    /// Adds the first `rows` rows of an experiment with their `errors` (row-major, one for each output) and `noise`;
    /// `slope(row, output, k)` is the derivative by its unknown `k`.
    pub(super) fn add(
        &mut self,
        unknowns: &Unknowns,
        experiment: usize,
        rows: usize,
        noise: &[f64],
        errors: &[f64],
        slope: impl Fn(usize, usize, usize) -> f64,
    ) {
        let (m, count) = (noise.len(), unknowns.common.len() + unknowns.own.len());
        let place: Vec<usize> = (0..count).map(|k| unknowns.place(experiment, k)).collect();
        let length = rows.div_ceil(BLOCKS).max(1);
        let first = self.blocks.len();
        self.blocks.extend(vec![vec![0.0; unknowns.len()]; rows.div_ceil(length)]);
        let mut slopes = vec![0.0; count];
        for row in 0..rows {
            for (c, noise) in noise.iter().enumerate() {
                let weight = 1.0 / (noise * noise);
                slopes.iter_mut().enumerate().for_each(|(k, s)| *s = slope(row, c, k));
                let block = &mut self.blocks[first + row / length];
                for (i, a) in slopes.iter().enumerate() {
                    block[place[i]] += weight * a * errors[row * m + c];
                    for (j, b) in slopes.iter().enumerate() {
                        self.gram[(place[i], place[j])] += weight * a * b;
                    }
                }
            }
        }
    }

    pub(super) fn right(&self) -> Vec<f64> {
        let mut sum = self.prior.clone();
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
    /// 1986): the root of the diagonal of `G⁻¹ (Σ_b g_b g_bᵀ · B/(B−1) + Σ⁻¹) G⁻¹`, with the priors `Σ`. Infinite where
    /// the data do not determine an unknown.
    pub(super) fn standard_errors(&self, unknowns: &Unknowns) -> Vec<f64> {
        let (blocks, size) = (self.blocks.len() as f64, self.gram.size());
        let priors: Vec<Vec<f64>> = unknowns
            .precisions()
            .into_iter()
            .enumerate()
            .filter(|(_, precision)| *precision > 0.0)
            .map(|(k, precision)| {
                let mut unit = vec![0.0; size];
                unit[k] = precision.sqrt();
                unit
            })
            .collect();
        let (Some(influences), Some(priors)) =
            (self.solve(0.0, &self.blocks), self.solve(0.0, &priors))
        else {
            return vec![f64::INFINITY; size];
        };
        (0..size)
            .map(|i| {
                let sum = |all: &[Vec<f64>]| all.iter().map(|x| x[i] * x[i]).sum::<f64>();
                let determined = self.gram[(i, i)] > 0.0;
                let variance = sum(&influences) * blocks / (blocks - 1.0).max(1.0) + sum(&priors);
                if determined { variance.sqrt() } else { f64::INFINITY }
            })
            .collect()
    }
}
