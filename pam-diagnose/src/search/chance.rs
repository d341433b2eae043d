//! What candidates explain by chance: the largest score under the fitted null.

use super::explore::{Scored, Search};
use crate::fit::{Sensitivities, Tolerances};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use pam_effects::effects::AnyEffect;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;

/// How much of the residual the luckiest candidate explains when none is at work.
///
/// The score of a candidate is the share of the weighted residual that a direction of its own, cleared of
/// what the uncertain numbers of model and recordings can imitate, explains by least squares. Its directions
/// are the derivatives by its parameters at its first starting values, and the change of the simulation at
/// each of them, which effects have as well whose derivative vanishes at "off":
/// `s = (Σ_b d_b)² / (‖Δ‖² ‖r‖²)` with `d_b` the inner product over a block of time. Under the null, blocks
/// have the residual's own size, colour and dependence on the motion, but no common sign: the score is drawn
/// again with random signs of the blocks (a wild block bootstrap, Mammen 1993), and the largest over all
/// candidates and starting values is kept.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Chance {
    /// 95th percentile of the largest share that any candidate explains by chance.
    pub share_q95: f64,
    /// Largest share that a candidate explains in the recordings, to first order.
    pub largest_share: f64,
    /// Share of the draws in which chance reaches that.
    pub p_value: f64,
    /// Number of draws.
    pub draws: usize,
}

impl Chance {
    /// What `members` effects together may explain by chance.
    #[must_use]
    pub fn of_set(&self, members: usize) -> f64 {
        1.0 - (1.0 - self.share_q95).powi(members as i32)
    }
}

/// Number of draws.
const DRAWS: usize = 400;
/// Fewest blocks into which the rows are parted.
const BLOCKS: usize = 24;

/// A direction in the rows of x, P_f and P_e; absent if it cannot be simulated.
type Direction = Option<[Vec<f64>; 3]>;

/// Inner products of one trial, block by block.
struct Products {
    /// `Zᵀ W r` of each block for the uncertain numbers Z.
    uncertain: Vec<Vec<f64>>,
    /// `Δᵀ W r` of each block for each candidate.
    candidates: Vec<Vec<f64>>,
    /// `Zᵀ W Z`, with the ties of the uncertain numbers on the diagonal.
    gram: Vec<Vec<f64>>,
    /// `Zᵀ W Δ` of each candidate.
    cross: Vec<Vec<f64>>,
    /// `Δᵀ W Δ` of each candidate.
    size: Vec<f64>,
    /// `rᵀ W r`.
    residual: f64,
}

impl<'e> Search<'_, 'e> {
    /// Share of the weighted squared residual of the fitted rows that goes from one hypothesis to another, in
    /// the weights of the first.
    #[must_use]
    pub fn explained(&self, from: &Scored<'e>, to: &Scored<'e>) -> f64 {
        let weights = self.split.train.weights(&from.fit.errors);
        let size = |s: &Scored<'e>| -> f64 {
            s.fit.errors.sums.iter().zip(weights).map(|(s, w)| s * w).sum()
        };
        1.0 - size(to) / size(from).max(1e-300)
    }

    /// Calibrates the largest score over all candidates by chance; `None` if nothing can be simulated.
    #[must_use]
    pub fn chance(&self, base: &Scored<'e>, seed: u64) -> Option<Chance> {
        let starts: Vec<(&'e dyn AnyEffect, Vec<f64>)> = self
            .candidates
            .iter()
            .flat_map(|c| c.starts(&self.scales).into_iter().map(move |s| (*c, s)))
            .collect();
        let problem = &self.split.train;
        let rows: usize = (0..problem.len()).map(|i| problem.rows(i)).sum();
        let block =
            (0..problem.len()).map(|i| problem.rows_per_block(i)).min()?.min(rows / BLOCKS).max(1);
        let weights = problem.weights(&base.fit.errors);
        let h = &base.fit.hypothesis;
        let trials: Option<Vec<Products>> = (0..problem.len())
            .into_par_iter()
            .map(|i| {
                let s = problem.sensitivities(h, i).ok()?;
                let changes: Vec<Vec<Direction>> = starts
                    .par_iter()
                    .enumerate()
                    .map(|(k, (effect, values))| {
                        let with = h.with(*effect, values);
                        let first = k == 0 || starts[k - 1].0.info().id != effect.info().id;
                        let parameters = effect.info().parameters.len();
                        let mut directions = vec![None; 1 + if first { parameters } else { 0 }];
                        if let Ok(r) = problem.residuals(&with, i) {
                            let change = |c: usize| {
                                s.residuals[c].iter().zip(&r[c]).map(|(a, b)| a - b).collect()
                            };
                            directions[0] = Some([0, 1, 2].map(change));
                        }
                        if first && let Ok(there) = problem.sensitivities(&with, i) {
                            let before = h.parameter_len();
                            for (to, column) in
                                directions[1..].iter_mut().zip(&there.columns[before..])
                            {
                                *to = Some(column.clone());
                            }
                        }
                        directions
                    })
                    .collect();
                let changes: Vec<Direction> = changes.into_iter().flatten().collect();
                Some(products(&s, &changes, weights, block, &problem.tolerances))
            })
            .collect();
        let trials = trials?;
        let residual: f64 = trials.iter().map(|t| t.residual).sum();
        if residual <= 0.0 {
            return None;
        }
        let scores = cleared(&trials);
        let largest = |signs: &mut dyn FnMut() -> f64| {
            let signs: Vec<f64> = (0..scores.blocks).map(|_| signs()).collect();
            scores
                .each
                .iter()
                .map(|(d, size)| {
                    let sum: f64 = d.iter().zip(&signs).map(|(d, s)| d * s).sum();
                    (sum * sum / (size * residual)).min(1.0)
                })
                .fold(0.0, f64::max)
        };
        let largest_share = largest(&mut || 1.0);
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x6a09_e667_f3bc_c908);
        let mut by_chance: Vec<f64> = (0..DRAWS)
            .map(|_| largest(&mut || if random.random_bool(0.5) { 1.0 } else { -1.0 }))
            .collect();
        by_chance.sort_by(f64::total_cmp);
        let reached = by_chance.iter().filter(|&&s| s >= largest_share).count();
        Some(Chance {
            share_q95: by_chance[DRAWS * 95 / 100],
            largest_share,
            p_value: (reached + 1) as f64 / (DRAWS + 1) as f64,
            draws: DRAWS,
        })
    }
}

fn products(
    s: &Sensitivities,
    changes: &[Direction],
    weights: [f64; 3],
    block: usize,
    tolerances: &Tolerances,
) -> Products {
    let dot = |a: &[Vec<f64>; 3], b: &[Vec<f64>; 3], from: usize, to: usize| -> f64 {
        (0..3)
            .filter(|&c| !a[c].is_empty() && !b[c].is_empty())
            .map(|c| {
                let (a, b) = (&a[c][from..to], &b[c][from..to]);
                weights[c] * a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>()
            })
            .sum()
    };
    let rows = s.residuals[0].len();
    let in_blocks = |a: &[Vec<f64>; 3]| -> Vec<f64> {
        (0..rows)
            .step_by(block)
            .map(|from| dot(a, &s.residuals, from, (from + block).min(rows)))
            .collect()
    };
    let nothing = [const { Vec::new() }; 3];
    let of = |change: &Direction| change.clone().unwrap_or_else(|| nothing.clone());
    let changes: Vec<[Vec<f64>; 3]> = changes.iter().map(of).collect();
    let against = |a: &[Vec<f64>; 3]| s.columns.iter().map(|z| dot(z, a, 0, rows)).collect();
    Products {
        uncertain: s.columns.iter().map(in_blocks).collect(),
        candidates: changes.iter().map(in_blocks).collect(),
        gram: tied(s.columns.iter().map(against).collect(), tolerances),
        cross: changes.iter().map(against).collect(),
        size: changes.iter().map(|a| dot(a, a, 0, rows)).collect(),
        residual: dot(&s.residuals, &s.residuals, 0, rows),
    }
}

/// Adds what ties the uncertain numbers to their measured values, in the order of the columns: what trials
/// share, then the trial's own.
fn tied(mut gram: Vec<Vec<f64>>, t: &Tolerances) -> Vec<Vec<f64>> {
    for (i, scale) in t.common().into_iter().chain(t.local()).enumerate() {
        gram[i][i] += 1.0 / (scale * scale);
    }
    gram
}

/// Inner products of each candidate with the residual, block by block over all trials, and its size; both
/// cleared of the uncertain numbers.
struct Cleared {
    each: Vec<(Vec<f64>, f64)>,
    blocks: usize,
}

fn cleared(trials: &[Products]) -> Cleared {
    let candidates = trials.first().map_or(0, |t| t.size.len());
    let blocks = trials.iter().map(|t| t.uncertain.first().map_or(0, Vec::len)).sum();
    let parts: Vec<Vec<(Vec<f64>, f64)>> = trials
        .iter()
        .map(|t| {
            let n = t.gram.len();
            let scale: Vec<f64> = (0..n).map(|i| t.gram[i][i].max(1e-300).sqrt()).collect();
            // The small ridge leaves directions alone that nearly coincide.
            let gram = Mat::from_fn(n, n, |i, j| {
                let ridge = if i == j { 1e-9 } else { 0.0 };
                t.gram[i][j] / (scale[i] * scale[j]) + ridge
            });
            let factor = gram.llt(Side::Lower).ok();
            (0..candidates)
                .map(|k| {
                    let right = Mat::from_fn(n, 1, |i, _| t.cross[k][i] / scale[i]);
                    let share: Vec<f64> = factor.as_ref().map_or(vec![0.0; n], |f| {
                        let solved = f.solve(&right);
                        (0..n).map(|i| solved[(i, 0)] / scale[i]).collect()
                    });
                    let imitated: f64 = share.iter().zip(&t.cross[k]).map(|(a, c)| a * c).sum();
                    let mut d = t.candidates[k].clone();
                    for (a, z) in share.iter().zip(&t.uncertain) {
                        d.iter_mut().zip(z).for_each(|(d, z)| *d -= a * z);
                    }
                    (d, (t.size[k] - imitated).max(0.0))
                })
                .collect()
        })
        .collect();
    let each = (0..candidates)
        .filter_map(|k| {
            let d: Vec<f64> = parts.iter().flat_map(|p| p[k].0.iter().copied()).collect();
            let size: f64 = parts.iter().map(|p| p[k].1).sum();
            let whole: f64 = trials.iter().map(|t| t.size[k]).sum();
            // What the uncertain numbers imitate to the last digits has no score of its own.
            (size > 1e-6 * whole && size > 0.0).then_some((d, size))
        })
        .collect();
    Cleared { each, blocks }
}
