//! The normal equations of all experiments together.

use super::hypothesis::Hypothesis;
use super::likelihood::ChannelErrors;
use super::problem::{Problem, Sensitivities};
use crate::error::DiagnoseError;
use crate::search::{Candidates, Nuisance};
use pam_core::parallel;
use pam_numerics::{ScaledCholesky, SquareMatrix, dot};

/// Whitened sensitivities of one experiment, by parameters, shared nuisances and its own nuisances.
struct Part {
    /// By unknown and channel.
    columns: Vec<Vec<Vec<f64>>>,
    /// `JᵀJ` of each channel.
    grams: Vec<Vec<f64>>,
}

/// Whitened sensitivities of all experiments at a hypothesis.
pub(super) struct Jacobian {
    parts: Vec<Part>,
}

/// Whitened residuals by experiment and channel.
pub(super) type WhitenedResiduals = Vec<Vec<Vec<f64>>>;

/// Normal equations over: parameters, shared nuisances, then the nuisances of each experiment.
pub(super) struct NormalEquations {
    /// Data term.
    gram: SquareMatrix,
    /// `Jᵀ W r` of every block of every experiment, in the joint unknowns.
    pub(super) blocks: Vec<Vec<f64>>,
    /// The experiment of each block.
    pub(super) experiments: Vec<usize>,
    /// One over the variance of each prior; zero for parameters without one.
    pub(super) precisions: Vec<f64>,
    /// Present deviation of each unknown from the mean of its prior.
    deviations: Vec<f64>,
    /// Number of parameters.
    parameters: usize,
}

impl<C: Candidates + ?Sized> Problem<'_, C> {
    /// Weights of the whitened channels at given errors, the slope of the cost by half their squares.
    pub(crate) fn weights(&self, errors: &ChannelErrors) -> Vec<f64> {
        errors.mean().iter().map(|m| 1.0 / (self.rows_per_observation * m.max(1.0))).collect()
    }

    /// Normal equations at a hypothesis whose errors are known.
    pub(super) fn normal_equations(
        &self,
        hypothesis: &Hypothesis,
        errors: &ChannelErrors,
    ) -> Result<NormalEquations, DiagnoseError> {
        let (jacobian, residuals) = self.jacobian(hypothesis)?;
        Ok(self.equations(&jacobian, &residuals, hypothesis, errors))
    }

    /// Sensitivities and residuals at a hypothesis.
    pub(super) fn jacobian(
        &self,
        hypothesis: &Hypothesis,
    ) -> Result<(Jacobian, WhitenedResiduals), DiagnoseError> {
        let channels = self.noise.channels();
        let each = parallel::map(self.len(), |i| {
            let Sensitivities { residuals, columns } =
                self.whitened_sensitivities(hypothesis, i)?;
            let grams = (0..channels).map(|c| gram(&columns, c)).collect();
            Ok((Part { columns, grams }, residuals))
        });
        let each: Result<Vec<_>, DiagnoseError> = each.into_iter().collect();
        let (parts, residuals) = each?.into_iter().unzip();
        Ok((Jacobian { parts }, residuals))
    }

    /// Normal equations for residuals and errors of a hypothesis with the sensitivities of one that may be another.
    pub(super) fn equations(
        &self,
        jacobian: &Jacobian,
        residuals: &WhitenedResiduals,
        hypothesis: &Hypothesis,
        errors: &ChannelErrors,
    ) -> NormalEquations {
        let weights = self.weights(errors);
        let (shared, local) = (self.system.shared(), self.system.local());
        let parameters = hypothesis.parameters(self.system).len();
        let common = parameters + shared.len();
        let unknowns = common + local.len() * self.len();
        let place = |experiment: usize, k: usize| {
            if k < common { k } else { common + local.len() * experiment + (k - common) }
        };
        let mut gram = SquareMatrix::zeros(unknowns);
        let (mut blocks, mut experiments) = (Vec::new(), Vec::new());
        for (experiment, (part, residuals)) in jacobian.parts.iter().zip(residuals).enumerate() {
            let own = part.columns.len();
            for i in 0..own {
                for j in 0..own {
                    let channels = weights.iter().zip(&part.grams);
                    let sum: f64 = channels.map(|(w, gram)| w * gram[i * own + j]).sum();
                    gram[(place(experiment, i), place(experiment, j))] += sum;
                }
            }
            let (rows, block) = (self.rows(experiment), self.rows_per_block(experiment));
            for b in 0..rows.div_ceil(block).max(1) {
                let range = b * block..((b + 1) * block).min(rows);
                let mut right = vec![0.0; unknowns];
                for (k, column) in part.columns.iter().enumerate() {
                    right[place(experiment, k)] = (0..weights.len())
                        .filter(|&c| !column[c].is_empty())
                        .map(|c| {
                            let r = &residuals[c][range.clone()];
                            weights[c] * dot(&column[c][range.clone()], r)
                        })
                        .sum();
                }
                blocks.push(right);
                experiments.push(experiment);
            }
        }
        let priors = hypothesis.parameter_priors(self.system);
        let mut precisions: Vec<f64> = priors.iter().map(|[prior, _]| prior.powi(-2)).collect();
        let mut deviations: Vec<f64> = priors.iter().map(|[_, value]| *value).collect();
        let precision = |n: &Nuisance| 1.0 / (n.deviation * n.deviation);
        precisions.extend(shared.iter().map(precision));
        deviations.extend(&hypothesis.shared);
        for values in &hypothesis.locals {
            precisions.extend(local.iter().map(precision));
            deviations.extend(values);
        }
        NormalEquations { gram, blocks, experiments, precisions, deviations, parameters }
    }
}

/// `JᵀJ` of one channel.
fn gram(columns: &[Vec<Vec<f64>>], channel: usize) -> Vec<f64> {
    let unknowns = columns.len();
    let mut gram = vec![0.0; unknowns * unknowns];
    for i in 0..unknowns {
        for j in 0..=i {
            let product = dot(&columns[i][channel], &columns[j][channel]);
            gram[i * unknowns + j] = product;
            gram[j * unknowns + i] = product;
        }
    }
    gram
}

impl NormalEquations {
    pub(super) fn unknowns(&self) -> usize {
        self.precisions.len()
    }

    fn entry(&self, i: usize, j: usize) -> f64 {
        self.gram[(i, j)] + if i == j { self.precisions[i] } else { 0.0 }
    }

    /// The factor of the Hessian with the priors.
    pub(super) fn factor(&self) -> Option<ScaledCholesky> {
        ScaledCholesky::new(self.unknowns(), |i, j| self.entry(i, j), 0.0)
    }

    /// Total right-hand side with the priors.
    fn right(&self) -> Vec<f64> {
        let priors = self.precisions.iter().zip(&self.deviations);
        let mut right: Vec<f64> = priors.map(|(t, d)| -t * d).collect();
        for block in &self.blocks {
            right.iter_mut().zip(block).for_each(|(r, b)| *r += b);
        }
        right
    }

    /// The damped step. Where it would lead shared nuisances out of their limits, those go to the limits, and everything
    /// else where it has to then; `None` if the equations cannot be solved.
    pub(super) fn step(&self, damping: f64, shared: &[Nuisance]) -> Option<Vec<f64>> {
        let mut prescribed: Vec<(usize, f64)> = Vec::new();
        loop {
            let step = self.solve(damping, &prescribed)?;
            let before = prescribed.len();
            for (k, n) in shared.iter().enumerate() {
                let at = self.parameters + k;
                let (value, change) = (self.deviations[at], step[at]);
                let limit = if change < 0.0 { n.limits[0] } else { n.limits[1] };
                let beyond = value + change < n.limits[0] || value + change > n.limits[1];
                if beyond && prescribed.iter().all(|p| p.0 != at) {
                    prescribed.push((at, limit - value));
                }
            }
            if prescribed.len() == before {
                return Some(step);
            }
        }
    }

    /// Drop of the cost by a step, to first order.
    pub(super) fn expected_drop(&self, step: &[f64]) -> f64 {
        dot(step, &self.right())
    }

    /// The damped step, with prescribed changes of some unknowns.
    fn solve(&self, damping: f64, prescribed: &[(usize, f64)]) -> Option<Vec<f64>> {
        let mut right = self.right();
        for &(at, change) in prescribed {
            for (i, r) in right.iter_mut().enumerate() {
                *r -= self.entry(i, at) * change;
            }
        }
        for &(at, change) in prescribed {
            right[at] = change * (1.0 + damping);
        }
        let is_prescribed = |i: usize| prescribed.iter().any(|p| p.0 == i);
        let entry = |i: usize, j: usize| {
            if is_prescribed(i) || is_prescribed(j) {
                f64::from(u8::from(i == j))
            } else {
                self.entry(i, j)
            }
        };
        ScaledCholesky::new(self.unknowns(), entry, damping)?.solve(&right)
    }
}
