//! How well noise that was learned from few rows describes others.

use super::{Noise, NoisePrior};
use crate::fit::dot;
use crate::residual::flexible::FeatureRows;
use crate::settings::DiagnosisSettings;
use pam_numerics::statistics::{mean, median};
use std::ops::Range;

/// Parts of each recording, of which each is left out once.
const FOLDS: usize = 3;

/// The mean square of the whitened residual of a channel in rows from which its noise was not learned: 1 where it was learned from many
/// rows. Parts of the recordings are left out one after another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnseenLevel {
    /// The median over the parts, at least 1. Something that begins or ends within the recordings does not raise it.
    pub median: f64,
    /// The mean over the parts, at least 1.
    pub mean: f64,
}

impl UnseenLevel {
    /// Of noise that is known.
    pub(super) const KNOWN: Self = Self { median: 1.0, mean: 1.0 };
}

/// Three-fold cross-validation of the noise level of each channel; a fold is a contiguous third of every recording. The level is that of
/// the residual or, if smaller, of the residual after a flexible model fitted to the other two thirds. `None` if those have too few rows.
pub(super) fn unseen_levels(
    rows: &FeatureRows,
    experiments: &[usize],
    prior: &NoisePrior,
    settings: &DiagnosisSettings,
) -> Option<Vec<UnseenLevel>> {
    let of_fold = |fold: usize| levels_of_fold(rows, experiments, prior, settings, fold);
    let folds: Vec<Vec<f64>> = (0..FOLDS).map(of_fold).collect::<Option<_>>()?;
    let of_channel = |c: usize| {
        let of_folds: Vec<f64> = folds.iter().map(|f| f[c]).collect();
        UnseenLevel { median: median(&of_folds).max(1.0), mean: mean(&of_folds).max(1.0) }
    };
    Some((0..rows.residuals.len()).map(of_channel).collect())
}

/// The levels of all channels in one part of all recordings.
fn levels_of_fold(
    rows: &FeatureRows,
    experiments: &[usize],
    prior: &NoisePrior,
    settings: &DiagnosisSettings,
    fold: usize,
) -> Option<Vec<f64>> {
    let (mut seen, mut of_seen, mut unseen) = (Vec::new(), Vec::new(), Vec::new());
    for (all, &e) in rows.experiments.iter().zip(experiments) {
        let at = |k: usize| all.start + k * all.len() / FOLDS;
        let left_out = at(fold)..at(fold + 1);
        let others = [all.start..left_out.start, left_out.end..all.end];
        for range in others.into_iter().filter(|r| !r.is_empty()) {
            seen.push(range);
            of_seen.push(e);
        }
        unseen.push(left_out);
    }
    let (seen, unseen) = (rows.at(&seen), rows.at(&unseen));
    let models = seen.models(&settings.verdict)?;
    let noise = Noise::of_rows((&seen, &models), &of_seen, prior, &settings.noise)?.common();
    let left = unseen.left(&models);
    let [plain, less] =
        [&unseen.residuals, &left].map(|channels| levels(&noise, channels, &unseen.experiments));
    Some(plain.into_iter().zip(less).map(|(plain, less)| plain.min(less)).collect())
}

/// The mean square of each channel, whitened experiment by experiment.
fn levels(noise: &Noise, channels: &[Vec<f64>], experiments: &[Range<usize>]) -> Vec<f64> {
    let mut squares = vec![Vec::new(); channels.len()];
    for range in experiments {
        let own: Vec<Vec<f64>> = channels.iter().map(|c| c[range.clone()].to_vec()).collect();
        for (squares, white) in squares.iter_mut().zip(noise.whitened(0, &own)) {
            squares.push(dot(&white, &white) / white.len().max(1) as f64);
        }
    }
    squares.iter().map(|s| mean(s)).collect()
}
