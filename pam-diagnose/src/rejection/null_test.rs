//! Names that explain no more than chance: the max-statistic null test.

use crate::fit::{Fit, Problem, dot};
use crate::linearised::{Linearised, Products, all_starts};
use crate::search::Candidates;
use crate::settings::RejectionSettings;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::Serialize;

/// How much of the residual the best candidate explains when none is at work.
///
/// The score of a direction of a candidate ([`linearised`](crate::linearised)) is the share of the whitened residual that
/// it explains by least squares, `s = (Σ_b d_b)² / (‖Δ‖² ‖r‖²)` with `d_b` the inner product over a block of time. Under
/// the null hypothesis, blocks have the residual's own size, what is left of its colour, and its dependence on the motion,
/// but no common sign: the score is drawn again with random signs of the blocks (a wild block bootstrap, Mammen 1993), and
/// the maximum over all candidates and directions is kept, which controls the family-wise error of the whole screening
/// (Westfall and Young 1993).
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
    /// Blocks of rows that are drawn.
    pub blocks: usize,
    /// Share of the whitened residual of the fitted rows that the named causes explain together.
    pub named_share: f64,
}

impl NullTest {
    /// Calibrates the largest score over all directions; `None` if there are none.
    pub(crate) fn of(
        linearised: &Linearised,
        settings: &RejectionSettings,
        seed: u64,
    ) -> Option<Self> {
        let residual = linearised.residual;
        let directions: Vec<(&[f64], f64)> = linearised
            .usable()
            .map(|k| (linearised.blocks[k].as_slice(), 1.0 / (linearised.size(k) * residual)))
            .collect();
        let blocks = directions.first()?.0.len();
        if residual <= 0.0 {
            return None;
        }
        let largest = |signs: &[f64]| {
            let share = |(d, scale): &(&[f64], f64)| dot(d, signs).powi(2) * scale;
            directions.iter().map(|d| share(d).min(1.0)).fold(0.0, f64::max)
        };
        let largest_share = largest(&vec![1.0; blocks]);
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x6a09_e667_f3bc_c908);
        let draws = settings.null_draws;
        let mut null: Vec<f64> = (0..draws)
            .map(|_| {
                let sign = |_| if random.random_bool(0.5) { 1.0 } else { -1.0 };
                largest(&(0..blocks).map(sign).collect::<Vec<f64>>())
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
            blocks,
            named_share: 0.0,
        })
    }

    /// The same for the base model of a problem, fitted already.
    #[must_use]
    pub fn calibrate<C: Candidates + ?Sized>(
        problem: &Problem<'_, C>,
        base: &crate::fit::Hypothesis,
        seed: u64,
    ) -> Option<Self> {
        let products = Products::at(problem, base, &all_starts(problem.system))?;
        Self::of(&products.beside(), &problem.settings.rejection, seed)
    }
}

/// Share of the whitened squared residual of the fitted rows that goes from one fit to another, in the weights of the
/// first.
pub(crate) fn explained<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    from: &Fit,
    to: &Fit,
) -> f64 {
    let weights = problem.weights(&from.errors);
    let size = |fit: &Fit| dot(&fit.errors.sums, &weights);
    1.0 - size(to) / size(from).max(1e-300)
}
