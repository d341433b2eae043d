//! The noise of each channel, from the data alone.

use crate::fit::fitted_outputs;
use crate::search::Candidates;
use crate::settings::DataSettings;
use pam_numerics::statistics::mean;

/// The standard deviation of the noise of each fitted channel, by [`noise_deviation`] of its row means.
#[must_use]
pub fn estimated_noise<C: Candidates + ?Sized>(
    system: &C,
    experiments: &[usize],
    settings: &DataSettings,
) -> Vec<f64> {
    let points = system.points_per_row();
    fitted_outputs(system)
        .map(|(c, _)| {
            let rows = |&e: &usize| -> Vec<f64> {
                let measured = system.measured(e, c).chunks_exact(points);
                measured.map(|r| r.iter().sum::<f64>() / points as f64).collect()
            };
            let series: Vec<Vec<f64>> = experiments.iter().map(rows).collect();
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
