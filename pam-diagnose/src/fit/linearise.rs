//! Residuals and sensitivities of one trial, summed into normal equations.

use super::hypothesis::{Common, Hypothesis, Local};
use super::likelihood::CHANNELS;
use super::problem::{POINTS_PER_ROW, Problem, row_means};
use pam_core::Scalar;
use pam_effects::effects::{Derivatives, WIDTH};
use pam_effects::simulation::{Diverged, Trajectory, simulate};
use std::ops::Range;

/// One trial's residuals, and their derivatives (of the simulation) by every unknown: parameters of
/// effects, what trials share, the trial's own.
pub(crate) struct Sensitivities {
    /// Residuals of x, P_f, P_e.
    pub(crate) residuals: [Vec<f64>; 3],
    /// For each unknown and channel one column of rows; empty where it is zero.
    pub(crate) columns: Vec<[Vec<f64>; 3]>,
}

/// Normal equations of one trial: parameters, then what trials share, then its own.
pub(super) struct Normal {
    pub(super) gram: Vec<f64>,
    /// `Jᵀ W r` of each block of rows.
    pub(super) blocks: Vec<Vec<f64>>,
    pub(super) unknowns: usize,
}

impl Problem<'_> {
    /// Residuals and sensitivities of a trial at a hypothesis.
    pub(crate) fn sensitivities(
        &self,
        hypothesis: &Hypothesis<'_>,
        trial: usize,
    ) -> Result<Sensitivities, Diverged> {
        let parameters = hypothesis.parameters();
        let simulated = parameters.len() + Common::SIMULATED + Local::SIMULATED;
        let window = self.windows[trial].clone();
        let t = self.trials[trial];
        let mut columns = Vec::with_capacity(simulated + 3);
        let mut residuals = [const { Vec::new() }; 3];
        let mut by_lead = [const { Vec::new() }; 3];
        let mut out = Trajectory::default();
        for first in (0..simulated).step_by(WIDTH) {
            let (values, nuisances) = seeded(hypothesis, trial, first);
            simulate::<Derivatives>(
                t,
                &self.base,
                &hypothesis.effects,
                &values,
                &nuisances,
                &mut out,
            )?;
            if first == 0 {
                for (at, (r, c)) in residuals.iter_mut().zip(CHANNELS).enumerate() {
                    let plain: Vec<f64> = out.channels[c].iter().map(|v| v.value).collect();
                    *r = row_means(&t.record.measured[c], &plain, window.clone());
                    by_lead[at] =
                        by_time(&plain, window.clone(), t.record.sample_s / t.record.step_s);
                }
            }
            for k in 0..WIDTH.min(simulated - first) {
                columns.push(CHANNELS.map(|c| {
                    out.channels[c][window.clone()]
                        .chunks_exact(POINTS_PER_ROW)
                        .map(|row| {
                            let sum: f64 = row.iter().map(|v| v.derivatives[k]).sum();
                            sum / POINTS_PER_ROW as f64
                        })
                        .collect()
                }));
            }
        }
        columns.insert(parameters.len() + Common::LEAD, by_lead);
        let offsets = hypothesis.locals[trial].offset_kpa;
        let rows = self.rows(trial);
        for (i, offset) in offsets.into_iter().enumerate() {
            residuals[1 + i].iter_mut().for_each(|r| *r -= offset);
            let mut unit = [const { Vec::new() }; 3];
            unit[1 + i] = vec![1.0; rows];
            columns.push(unit);
        }
        Ok(Sensitivities { residuals, columns })
    }

    /// Normal equations of a trial with weights (one over variance) for the channels.
    pub(super) fn normal(&self, trial: usize, s: &Sensitivities, weights: [f64; 3]) -> Normal {
        let unknowns = s.columns.len();
        let mut gram = vec![0.0; unknowns * unknowns];
        for i in 0..unknowns {
            for j in 0..=i {
                let mut sum = 0.0;
                for (c, weight) in weights.iter().enumerate() {
                    sum += weight * dot(&s.columns[i][c], &s.columns[j][c]);
                }
                gram[i * unknowns + j] = sum;
                gram[j * unknowns + i] = sum;
            }
        }
        let (rows, block) = (self.rows(trial), self.rows_per_block(trial));
        let blocks = (0..rows.div_ceil(block).max(1))
            .map(|b| {
                let range = b * block..((b + 1) * block).min(rows);
                let right = |column: &[Vec<f64>; 3]| {
                    (0..3)
                        .filter(|&c| !column[c].is_empty())
                        .map(|c| {
                            let r = &s.residuals[c][range.clone()];
                            weights[c] * dot(&column[c][range.clone()], r)
                        })
                        .sum()
                };
                s.columns.iter().map(right).collect()
            })
            .collect();
        Normal { gram, blocks, unknowns }
    }
}

/// Derivative of each row by `step_share` of a step of time, by central differences over the row. A force that
/// acts earlier moves what the joint shows earlier, apart from what remains of the start.
fn by_time(values: &[f64], window: Range<usize>, step_share: f64) -> Vec<f64> {
    let last = values.len() - 1;
    window
        .step_by(POINTS_PER_ROW)
        .map(|from| {
            // The mean of central differences over a row is what its ends leave.
            let (to, before) = (from + POINTS_PER_ROW - 1, from.saturating_sub(1));
            let ends = values[to] + values[(to + 1).min(last)] - values[from] - values[before];
            0.5 * step_share * ends / POINTS_PER_ROW as f64
        })
        .collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Values and nuisances with the unknowns from `first` on as directions. Parameters with a logarithmic
/// coordinate carry the derivative by that.
fn seeded(
    hypothesis: &Hypothesis<'_>,
    trial: usize,
    first: usize,
) -> (Vec<Derivatives>, pam_effects::simulation::Nuisances<Derivatives>) {
    let parameters = hypothesis.parameters();
    let mut values: Vec<Derivatives> =
        hypothesis.values.iter().map(|&v| Derivatives::constant(v)).collect();
    for (k, (at, info)) in parameters.iter().enumerate() {
        let seed = Derivatives::seeded(values[*at].value, k, first);
        let slope = if info.logarithmic { seed.value } else { 1.0 };
        values[*at] = Derivatives::new(seed.value, seed.derivatives.map(|d| d * slope));
    }
    let mut n = hypothesis.nuisances::<Derivatives>(trial);
    let [air_f, air_e] = &mut n.log_air;
    let others =
        [&mut n.log_mass, &mut n.log_deformation, &mut n.start_mm, &mut n.start_mm_s, air_f, air_e];
    for (k, value) in others.into_iter().enumerate() {
        *value = Derivatives::seeded(value.value, parameters.len() + k, first);
    }
    (values, n)
}
