//! Names that explain no more than chance: the max-statistic null test.

use crate::fit::{Problem, Sensitivities, dot};
use crate::search::{Candidates, Scored};
use pam_core::parallel;
use pam_numerics::ScaledCholesky;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::Serialize;

/// How much of the residual the best candidate explains when none is at work.
///
/// The score of a candidate is the share of the weighted residual that a direction of its own, cleared of what the
/// nuisances can imitate, explains by least squares. Its directions are the derivatives by its parameters at its first
/// starting values, and the change of the simulation at each starting value, which candidates have as well whose
/// derivative vanishes at "off": `s = (Σ_b d_b)² / (‖Δ‖² ‖r‖²)` with `d_b` the inner product over a block of time.
/// Under the null hypothesis, blocks have the residual's own size, colour and dependence on the motion, but no common
/// sign: the score is drawn again with random signs of the blocks (a wild block bootstrap, Mammen 1993), and the
/// maximum over all candidates and directions is kept, which controls the family-wise error (Westfall and Young 1993).
///
/// Blocks of random signs are independent; those of noise that is correlated over a good part of a block are not, and
/// the variance of their sum is larger by `2 ρ₁ Σ_b e_b²` with the correlation `ρ₁` of neighbouring blocks. `e_b` is the inner
/// product with the residual that the named causes leave: the residual of the base model contains the causes, whose
/// blocks resemble their neighbours as the motion does. Each direction's draws are multiplied by
/// `1 + 2 ρ₁ Σ e_b² / Σ d_b²`, with `ρ₁` about the mean, free of its bias `−1/n`, where it is positive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NullTest {
    /// Quantile (95 % by default) of the largest share that any candidate explains under the null hypothesis.
    pub share_q95: f64,
    /// Largest share that a candidate explains in the recordings, to first order.
    pub largest_share: f64,
    /// Share of the draws that reach it.
    pub p_value: f64,
    /// Number of draws.
    pub draws: usize,
    /// Share of the weighted residual of the fitted rows that the named causes explain together.
    pub named_share: f64,
}

/// A direction in the rows of each fitted channel; empty if it cannot be simulated.
type Direction = Vec<Vec<f64>>;

/// Inner products of one experiment, block by block.
struct Products {
    /// `Zᵀ W r` of each block for the nuisances Z.
    nuisances: Vec<Vec<f64>>,
    /// `Δᵀ W r` of each block for each direction.
    directions: Vec<Vec<f64>>,
    /// Both again with the residual that the named causes leave.
    remaining: [Vec<Vec<f64>>; 2],
    /// `Zᵀ W Z`, with the precisions of the priors on the diagonal.
    gram: Vec<Vec<f64>>,
    /// `Zᵀ W Δ` of each direction.
    cross: Vec<Vec<f64>>,
    /// `Δᵀ W Δ` of each direction.
    size: Vec<f64>,
    /// `rᵀ W r`.
    residual: f64,
}

impl NullTest {
    /// Calibrates the largest score over all candidates; `None` if nothing can be simulated. `named` is the fit whose
    /// residuals tell how the noise is correlated, the base model if nothing is named.
    #[must_use]
    pub fn calibrate<C: Candidates + ?Sized>(
        problem: &Problem<'_, C>,
        base: &Scored,
        named: &Scored,
        seed: u64,
    ) -> Option<Self> {
        let settings = &problem.settings.rejection;
        let system = problem.system;
        let starts: Vec<(usize, Vec<f64>)> = (0..system.candidate_len())
            .flat_map(|c| system.starts(c).into_iter().map(move |s| (c, s)))
            .collect();
        let rows: usize = (0..problem.len()).map(|i| problem.rows(i)).sum();
        let blocks = (0..problem.len()).map(|i| problem.rows_per_block(i)).min()?;
        let block = blocks.min(rows / settings.null_blocks).max(1);
        let weights = problem.weights(&base.fit.errors);
        let h = base.hypothesis();
        let experiments: Option<Vec<Products>> = parallel::map(problem.len(), |i| {
            let s = problem.sensitivities(h, i).ok()?;
            let remaining = problem.residuals(named.hypothesis(), i).ok()?;
            let directions: Vec<Vec<Direction>> = parallel::map(starts.len(), |k| {
                let (candidate, values) = &starts[k];
                let with = h.with(*candidate, values);
                let first = k == 0 || starts[k - 1].0 != *candidate;
                let parameters = system.candidate(*candidate).parameters.len();
                let none = vec![Vec::new(); weights.len()];
                let mut directions = vec![none; 1 + if first { parameters } else { 0 }];
                if let Ok(r) = problem.residuals(&with, i) {
                    let change = |(a, b): (&Vec<f64>, &Vec<f64>)| {
                        a.iter().zip(b).map(|(a, b)| a - b).collect()
                    };
                    directions[0] = s.residuals.iter().zip(&r).map(change).collect();
                }
                if first && let Ok(there) = problem.sensitivities(&with, i) {
                    // The base has no parameters: those of the candidate come first.
                    for (to, column) in directions[1..].iter_mut().zip(there.columns) {
                        *to = column;
                    }
                }
                directions
            });
            let directions: Vec<Direction> = directions.into_iter().flatten().collect();
            Some(products(system, &s, &remaining, &directions, &weights, block))
        })
        .into_iter()
        .collect();
        let experiments = experiments?;
        let residual: f64 = experiments.iter().map(|t| t.residual).sum();
        if residual <= 0.0 {
            return None;
        }
        let scores = cleared(&experiments);
        let largest = |signs: &[f64], factor: fn(&Cleared) -> f64| {
            let share =
                |d: &Cleared| factor(d) * dot(&d.blocks, signs).powi(2) / (d.size * residual);
            scores.iter().map(|d| share(d).min(1.0)).fold(0.0, f64::max)
        };
        let blocks = scores.first().map_or(0, |d| d.blocks.len());
        let largest_share = largest(&vec![1.0; blocks], |_| 1.0);
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x6a09_e667_f3bc_c908);
        let draws = settings.null_draws;
        let mut null: Vec<f64> = (0..draws)
            .map(|_| {
                let sign = |_| if random.random_bool(0.5) { 1.0 } else { -1.0 };
                largest(&(0..blocks).map(sign).collect::<Vec<f64>>(), |d| d.correlated)
            })
            .collect();
        null.sort_by(f64::total_cmp);
        let reached = null.iter().filter(|&&s| s >= largest_share).count();
        let at = (draws as f64 * settings.null_quantile + 1e-9) as usize;
        Some(Self {
            share_q95: null[at.min(draws - 1)],
            largest_share,
            p_value: (reached + 1) as f64 / (draws + 1) as f64,
            draws,
            named_share: 0.0,
        })
    }

    /// The share that a set of so many members may explain under the null hypothesis.
    #[must_use]
    pub fn of_set(&self, members: usize) -> f64 {
        1.0 - (1.0 - self.share_q95).powi(members as i32)
    }
}

/// Share of the weighted squared residual of the fitted rows that goes from one fit to another, in the weights of the
/// first.
pub(crate) fn explained<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    from: &Scored,
    to: &Scored,
) -> f64 {
    let weights = problem.weights(&from.fit.errors);
    let size = |s: &Scored| dot(&s.fit.errors.sums, &weights);
    1.0 - size(to) / size(from).max(1e-300)
}

fn products<C: Candidates + ?Sized>(
    system: &C,
    s: &Sensitivities,
    remaining: &Direction,
    directions: &[Direction],
    weights: &[f64],
    block: usize,
) -> Products {
    let inner = |a: &Direction, b: &Direction, from: usize, to: usize| -> f64 {
        (0..weights.len())
            .filter(|&c| !a[c].is_empty() && !b[c].is_empty())
            .map(|c| weights[c] * dot(&a[c][from..to], &b[c][from..to]))
            .sum()
    };
    let rows = s.residuals[0].len();
    let in_blocks = |a: &Direction, r: &Direction| -> Vec<f64> {
        (0..rows).step_by(block).map(|from| inner(a, r, from, (from + block).min(rows))).collect()
    };
    let all = |of: &[Direction], r| of.iter().map(|a| in_blocks(a, r)).collect();
    let against = |a: &Direction| s.columns.iter().map(|z| inner(z, a, 0, rows)).collect();
    let mut gram: Vec<Vec<f64>> = s.columns.iter().map(against).collect();
    for (i, n) in system.shared().iter().chain(system.local()).enumerate() {
        gram[i][i] += 1.0 / (n.deviation * n.deviation);
    }
    Products {
        nuisances: all(&s.columns, &s.residuals),
        directions: all(directions, &s.residuals),
        remaining: [all(&s.columns, remaining), all(directions, remaining)],
        gram,
        cross: directions.iter().map(against).collect(),
        size: directions.iter().map(|a| inner(a, a, 0, rows)).collect(),
        residual: inner(&s.residuals, &s.residuals, 0, rows),
    }
}

/// A direction in one experiment, cleared of the nuisances.
struct Part {
    blocks: Vec<f64>,
    remaining: Vec<f64>,
    size: f64,
}

/// A direction that is cleared of the nuisances.
struct Cleared {
    /// Its inner products with the residual, block by block over all experiments.
    blocks: Vec<f64>,
    /// Its squared size.
    size: f64,
    /// The variance of the sum of its blocks over that of blocks with independent signs, at least 1.
    correlated: f64,
}

/// Correlation of neighbouring blocks of the same experiment; at least 0.
fn neighbour_correlation(experiments: &[&[f64]]) -> f64 {
    let blocks: f64 = experiments.iter().map(|d| d.len() as f64).sum();
    let mean = experiments.iter().flat_map(|d| d.iter()).sum::<f64>() / blocks;
    let (mut neighbours, mut pairs, mut variance) = (0.0, 0.0, 0.0);
    for d in experiments {
        neighbours += d.windows(2).map(|w| (w[0] - mean) * (w[1] - mean)).sum::<f64>();
        pairs += d.len().saturating_sub(1) as f64;
        variance += d.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    }
    if pairs == 0.0 || variance <= 0.0 {
        return 0.0;
    }
    // `pairs / blocks` of the neighbours are there.
    (neighbours / variance + pairs / (blocks * blocks)).max(0.0)
}

/// Ridge that leaves directions alone that nearly coincide.
const RIDGE: f64 = 1e-9;
/// A direction of which the nuisances imitate all but this share has no score of its own: its last digits are rounding.
const OWN_SHARE: f64 = 1e-6;

fn cleared(experiments: &[Products]) -> Vec<Cleared> {
    let directions = experiments.first().map_or(0, |t| t.size.len());
    let parts: Vec<Vec<Part>> = experiments
        .iter()
        .map(|t| {
            let n = t.gram.len();
            let factor = ScaledCholesky::new(n, |i, j| t.gram[i][j], RIDGE);
            (0..directions)
                .map(|k| {
                    let solved = factor.as_ref().and_then(|f| f.solve(&t.cross[k]));
                    let share = solved.unwrap_or_else(|| vec![0.0; n]);
                    let imitated = dot(&share, &t.cross[k]);
                    let clear = |direction: &[f64], nuisances: &[Vec<f64>]| {
                        let mut d = direction.to_vec();
                        for (a, z) in share.iter().zip(nuisances) {
                            d.iter_mut().zip(z).for_each(|(d, z)| *d -= a * z);
                        }
                        d
                    };
                    let [nuisances, directions] = &t.remaining;
                    Part {
                        blocks: clear(&t.directions[k], &t.nuisances),
                        remaining: clear(&directions[k], nuisances),
                        size: (t.size[k] - imitated).max(0.0),
                    }
                })
                .collect()
        })
        .collect();
    (0..directions)
        .filter_map(|k| {
            let blocks: Vec<f64> = parts.iter().flat_map(|p| &p[k].blocks).copied().collect();
            let remaining: Vec<&[f64]> = parts.iter().map(|p| p[k].remaining.as_slice()).collect();
            let size: f64 = parts.iter().map(|p| p[k].size).sum();
            let whole: f64 = experiments.iter().map(|t| t.size[k]).sum();
            let left: f64 = remaining.iter().map(|e| dot(e, e)).sum();
            let share = (left / dot(&blocks, &blocks).max(f64::MIN_POSITIVE)).min(1.0);
            let correlated = 1.0 + 2.0 * neighbour_correlation(&remaining) * share;
            (size > OWN_SHARE * whole && size > 0.0).then_some(Cleared { blocks, size, correlated })
        })
        .collect()
}
