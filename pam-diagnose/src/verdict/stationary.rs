//! Whether what is left of a channel is stationary, as noise is.

use crate::fit::{Hypothesis, Problem};
use crate::search::Candidates;
use pam_numerics::statistics::{chi_square_quantile, mean};

/// Whether the mean squares of blocks of time of a whitened channel scatter no more than those of stationary noise do.
///
/// A block of `n` independent rows has a mean square whose variance is `(κ − 1)/n` times its square, with the kurtosis `κ`
/// of Student's t with [`event_freedom`](crate::settings::VerdictSettings::event_freedom) degrees of freedom. The sum of
/// the squared relative deviations, each over its variance, is compared with the quantile
/// [`stationary_probability`](crate::settings::VerdictSettings::stationary_probability) of χ². Rows whose simulation fails
/// are not stationary.
pub(crate) fn is_stationary<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    hypothesis: &Hypothesis,
    channel: usize,
) -> bool {
    let settings = &problem.settings.verdict;
    let kurtosis = 3.0 + 6.0 / (settings.event_freedom - 4.0).max(1.0);
    let (mut sum, mut freedom) = (0.0, 0.0);
    for i in 0..problem.len() {
        let Ok(white) = problem.whitened_residuals(hypothesis, i) else { return false };
        let block = problem.rows_per_short_block(i);
        let square = |b: &[f64]| b.iter().map(|v| v * v).sum::<f64>() / block as f64;
        let squares: Vec<f64> = white[channel].chunks_exact(block).map(square).collect();
        let level = mean(&squares);
        if squares.len() < 2 || level <= 0.0 {
            continue;
        }
        let variance = (kurtosis - 1.0) / block as f64;
        sum += squares.iter().map(|s| (s / level - 1.0).powi(2) / variance).sum::<f64>();
        freedom += squares.len() as f64 - 1.0;
    }
    freedom == 0.0 || sum < chi_square_quantile(settings.stationary_probability, freedom)
}
