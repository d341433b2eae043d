//! The noise of each channel, from the data alone, and the correlation length of a residual.

use super::OpenPart;
use crate::fit::fitted_outputs;
use crate::search::Candidates;
use crate::settings::DataSettings;
use pam_numerics::statistics::mean;

/// The standard deviation of the noise of each fitted channel, by [`noise_deviation`] of its row means in the open part
/// of each experiment.
#[must_use]
pub fn estimated_noise<C: Candidates + ?Sized>(
    system: &C,
    open: &[OpenPart],
    settings: &DataSettings,
) -> Vec<f64> {
    let points = system.points_per_row();
    fitted_outputs(system)
        .map(|(c, _)| {
            let rows = |part: &OpenPart| -> Vec<f64> {
                let end = system.point_at(part.experiment, part.end_s);
                let measured = system.measured(part.experiment, c)[..end].chunks_exact(points);
                measured.map(|r| r.iter().sum::<f64>() / points as f64).collect()
            };
            let series: Vec<Vec<f64>> = open.iter().map(rows).collect();
            noise_deviation(&series, settings.relative_noise)
        })
        .collect()
}

/// The standard deviation below which an error is no error: that of the noise, joined by a `relative` part of the
/// variation of the series, which stands for the errors of solver, grid and filters.
///
/// The noise is estimated from third differences, in which a slow motion has all but vanished; the median of their
/// sizes is not moved by a few jumps. For independent noise of standard deviation σ their variance is 20 σ².
#[must_use]
pub fn noise_deviation(series: &[Vec<f64>], relative: f64) -> f64 {
    let (mut noise, mut variation) = (Vec::new(), Vec::new());
    for rows in series {
        let third = |w: &[f64]| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs();
        let mut sizes: Vec<f64> = rows.windows(4).map(third).collect();
        if sizes.is_empty() {
            continue;
        }
        let middle = sizes.len() / 2;
        let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
        noise.push(*median / (0.6745 * 20.0_f64.sqrt()));
        let centre = mean(rows);
        let square = rows.iter().map(|r| (r - centre).powi(2)).sum::<f64>();
        variation.push((square / rows.len() as f64).sqrt());
    }
    if noise.is_empty() { 1e-9 } else { mean(&noise).hypot(relative * mean(&variation)).max(1e-9) }
}

/// Rows over which a residual is correlated, `1 + 2 Σ ρ_k` up to the first `ρ_k` below zero (Sokal 1997), at most
/// [`correlated_share`](DataSettings::correlated_share) of the rows.
#[must_use]
pub fn correlated_rows(errors: &[f64], settings: &DataSettings) -> f64 {
    let n = errors.len();
    let mean = errors.iter().sum::<f64>() / n as f64;
    let at_lag = |k: usize| -> f64 {
        errors.iter().zip(&errors[k..]).map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    let variance = at_lag(0);
    if variance <= 0.0 {
        return 1.0;
    }
    let sum: f64 = (1..(settings.lag_share * n as f64) as usize)
        .map(|k| at_lag(k) / variance)
        .take_while(|r| *r > 0.0)
        .sum();
    (1.0 + 2.0 * sum).min(settings.correlated_share * n as f64).max(1.0)
}
