//! Whether what is left of each channel is noise.

use crate::fit::{Hypothesis, Problem, dot, fitted_outputs};
use crate::residual::flexible::left_of_unseen;
use crate::search::Candidates;
use pam_numerics::statistics::{chi_square_quantile, mean, standard_deviation, t_quantile};
use serde::Serialize;

/// One channel of recordings that no decision has seen, beside its noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelBand {
    /// Key of the channel.
    pub channel: String,
    /// Root mean square of the whitened residual: 1 for noise.
    pub ratio: f64,
    /// The ratio that noise exceeds with a probability of `1 − band_probability`, by Student's t over blocks of time, with
    /// the uncertainty of the learned noise ([`Noise::unseen_level`](crate::noise::Noise::unseen_level)) and of the model's known
    /// errors, which may be twice as large in other recordings.
    pub upper: f64,
    /// Share of the whitened squared residual that a flexible model removes which was learned on the open rows.
    pub learnable_share: f64,
    /// Whether that share is more than chance.
    pub learnable: bool,
    /// Whether the channel is outside its band: more than noise is left, and either it can be learned, so that it is no
    /// noise of these recordings, or it is more than any noise. An error below the resolution of the sensor, the standard
    /// deviation q/√12 of its step q, is within.
    pub outside: bool,
}

/// The bands of all channels of `judged` rows under a hypothesis, beside a flexible model that was learned on other rows;
/// `None` if the simulation fails.
pub(crate) fn bands<C: Candidates + ?Sized>(
    learned: (&Problem<'_, C>, &Hypothesis),
    judged: (&Problem<'_, C>, &Hypothesis),
) -> Option<Vec<ChannelBand>> {
    let (problem, hypothesis) = judged;
    let settings = &problem.settings.verdict;
    let white: Vec<Vec<Vec<f64>>> = (0..problem.len())
        .map(|i| problem.whitened_residuals(hypothesis, i).ok())
        .collect::<Option<_>>()?;
    let learned_left = left_of_unseen(learned, judged)?;
    let all = fitted_outputs(problem.system).enumerate();
    Some(
        all.map(|(c, (output_index, output))| {
            // Mean squares of blocks of time, as they are and with what was learned taken out.
            let (mut own, mut less) = (Vec::new(), Vec::new());
            let mut from = 0;
            for (i, channels) in white.iter().enumerate() {
                let rows = channels[c].len();
                let block = problem.rows_per_short_block(i);
                let flexible = &learned_left[c][from..from + rows];
                let square = |b: &[f64]| b.iter().map(|v| v * v).sum::<f64>() / b.len() as f64;
                own.extend(channels[c].chunks_exact(block).map(|b| (square(b), block)));
                less.extend(flexible.chunks_exact(block).map(square));
                from += rows;
            }
            let squares: Vec<f64> = own.iter().map(|b| b.0).collect();
            let count = squares.len().max(1) as f64;
            let level = mean(&squares);
            // The scatter of the blocks, with that of Gaussian noise as a prior of a few blocks.
            let gaussian = own.iter().map(|b| 2.0 / b.1 as f64).sum::<f64>() / count;
            let scatter =
                if squares.len() > 1 { standard_deviation(&squares).powi(2) } else { 0.0 };
            let prior = settings.band_observations;
            let freedom = count - 1.0 + prior;
            let quantile = t_quantile(settings.band_probability, freedom);
            let error = |variance: f64, gaussian: f64| {
                (((count - 1.0) * variance + prior * gaussian) / freedom / count).sqrt()
            };
            // A channel that is much above its noise has blocks of a scatter of its own.
            let of_blocks = error(scatter.min(gaussian * level.max(1.0)), gaussian);
            // The noise itself may be larger than it was learned: f/χ² of f degrees of freedom.
            let f = problem.noise.freedom(c);
            let of_noise = match f.is_finite() {
                true => f / chi_square_quantile(1.0 - settings.band_probability, f) - 1.0,
                false => 0.0,
            };
            let unseen = problem.noise.unseen_level(c);
            // The model's own errors differ between recordings.
            let own_errors =
                (settings.inadequate_ratio.powi(2) - 1.0) * problem.noise.discrepancy_levels()[c];
            let upper = unseen.median + (quantile * of_blocks).hypot(of_noise) + own_errors;
            let gains: Vec<f64> = squares.iter().zip(&less).map(|(a, b)| a - b).collect();
            let gain = mean(&gains);
            let of_gain = if gains.len() > 1 { standard_deviation(&gains).powi(2) } else { 0.0 };
            let share = gain / level.max(f64::MIN_POSITIVE);
            let learnable = share > settings.learnable_share
                && gain > quantile * error(of_gain, gaussian * settings.learnable_share);
            let most = settings.unlearnable_ratio.powi(2) * unseen.mean;
            let outside = level > upper
                && (learnable || level > most)
                && error_is_resolved(judged, (c, output_index), level);
            ChannelBand {
                channel: output.key.clone(),
                ratio: level.sqrt(),
                upper: upper.sqrt(),
                learnable_share: share,
                learnable,
                outside,
            }
        })
        .collect(),
    )
}

/// Whether the errors of a channel (its place among the fitted ones, and among all) are larger than its noise by more than
/// the standard deviation of a quantisation to the steps of its sensor: where the motion is slow, that goes with the motion
/// and is not in the learned noise. `level` is the mean square of the whitened errors.
fn error_is_resolved<C: Candidates + ?Sized>(
    (problem, hypothesis): (&Problem<'_, C>, &Hypothesis),
    (channel, output): (usize, usize),
    level: f64,
) -> bool {
    let steps = problem.experiments.iter().map(|&e| problem.system.resolution(e, output));
    let unresolved = steps.fold(0.0, f64::max).powi(2) / 12.0;
    let rows: Vec<f64> = (0..problem.len())
        .filter_map(|i| problem.residuals(hypothesis, i).ok())
        .flat_map(|mut channels| channels.swap_remove(channel))
        .collect();
    let square = dot(&rows, &rows) / rows.len().max(1) as f64;
    // Slow noise hides what the rows have beyond it, and whitened rows what is slow.
    let whole = square - problem.noise.deviation(channel).powi(2);
    let innovations = (level - 1.0) * problem.noise.channel(channel).innovation().powi(2);
    whole.max(innovations) > unresolved
}
