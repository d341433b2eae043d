//! The normal equations of all trials together.

use super::hypothesis::{Common, Hypothesis, Local};
use super::linearise::Normal;
use super::problem::Problem;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Normal equations over: parameters of effects, what the trials share, then each trial's own numbers.
pub(super) struct Joint {
    /// Data term.
    pub(super) gram: Mat<f64>,
    /// `Jᵀ W r` of every block of every trial, in the joint unknowns.
    pub(super) blocks: Vec<Vec<f64>>,
    /// One over the variance of each tied number; zero for parameters.
    pub(super) ties: Vec<f64>,
    /// Present deviation of each tied number.
    pub(super) deviations: Vec<f64>,
}

impl Problem<'_> {
    pub(super) fn joint(&self, hypothesis: &Hypothesis<'_>, parts: &[Normal]) -> Joint {
        let shared = hypothesis.parameter_len() + Common::LEN;
        let unknowns = shared + Local::LEN * self.len();
        let place = |trial: usize, k: usize| {
            if k < shared { k } else { shared + Local::LEN * trial + (k - shared) }
        };
        let mut gram = Mat::zeros(unknowns, unknowns);
        let mut blocks = Vec::new();
        for (trial, part) in parts.iter().enumerate() {
            for i in 0..part.unknowns {
                for j in 0..part.unknowns {
                    gram[(place(trial, i), place(trial, j))] += part.gram[i * part.unknowns + j];
                }
            }
            for block in &part.blocks {
                let mut right = vec![0.0; unknowns];
                for (k, value) in block.iter().enumerate() {
                    right[place(trial, k)] = *value;
                }
                blocks.push(right);
            }
        }
        let t = &self.tolerances;
        let mut ties = vec![0.0; shared - Common::LEN];
        let mut deviations = ties.clone();
        ties.extend(t.common().map(precision));
        deviations.extend(hypothesis.common.values());
        for local in &hypothesis.locals {
            ties.extend(t.local().map(precision));
            deviations.extend(local.values());
        }
        Joint { gram, blocks, ties, deviations }
    }
}

fn precision(sd: f64) -> f64 {
    1.0 / (sd * sd)
}

impl Joint {
    /// Total right-hand side with the ties.
    pub(super) fn right(&self) -> Vec<f64> {
        let mut right: Vec<f64> =
            self.ties.iter().zip(&self.deviations).map(|(t, d)| -t * d).collect();
        for block in &self.blocks {
            right.iter_mut().zip(block).for_each(|(r, b)| *r += b);
        }
        right
    }

    /// Hessian with ties, and with a share `damping` of each diagonal entry on top.
    pub(super) fn hessian(&self, damping: f64) -> Mat<f64> {
        let mut h = self.gram.clone();
        for (i, tie) in self.ties.iter().enumerate() {
            let own = h[(i, i)] + tie;
            // Directions without any sensitivity stay where they are.
            h[(i, i)] = if own > 0.0 { own * (1.0 + damping) } else { 1.0 };
        }
        h
    }

    /// The damped step from a hypothesis. Where it would lead the force out of its range, the lead goes to the end
    /// of it, and everything else where it has to then; `None` if the equations cannot be solved.
    pub(super) fn step_within(&self, damping: f64, from: &Hypothesis<'_>) -> Option<Vec<f64>> {
        let at = from.parameter_len() + Common::LEAD;
        let free = self.step(damping, None)?;
        match from.common.lead_left(free[at]) {
            Some(left) => self.step(damping, Some((at, left))),
            None => Some(free),
        }
    }

    /// The damped step, with the change of one unknown prescribed if asked for; `None` if the equations cannot be
    /// solved.
    fn step(&self, damping: f64, prescribed: Option<(usize, f64)>) -> Option<Vec<f64>> {
        let mut h = self.hessian(damping);
        let n = h.nrows();
        let mut right = self.right();
        if let Some((at, change)) = prescribed {
            for i in 0..n {
                right[i] -= h[(i, at)] * change;
                (h[(at, i)], h[(i, at)]) = (0.0, 0.0);
            }
            (h[(at, at)], right[at]) = (1.0, change);
        }
        // Scaled to a unit diagonal, since the unknowns differ by many orders of magnitude.
        let scale: Vec<f64> = (0..n).map(|i| h[(i, i)].sqrt().recip()).collect();
        let scaled = Mat::from_fn(n, n, |i, j| h[(i, j)] * scale[i] * scale[j]);
        let factor = scaled.llt(Side::Lower).ok()?;
        let solved = factor.solve(&Mat::from_fn(n, 1, |i, _| right[i] * scale[i]));
        let step: Vec<f64> = (0..n).map(|i| solved[(i, 0)] * scale[i]).collect();
        step.iter().all(|s| s.is_finite()).then_some(step)
    }
}
