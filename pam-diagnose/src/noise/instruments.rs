//! A first estimate of the noise of each channel, from the data alone.

use super::{Covariances, Discrepancy, autocovariance};
use crate::data::OpenPart;
use crate::fit::fitted_outputs;
use crate::search::Candidates;
use crate::settings::NoiseSettings;
use pam_numerics::statistics::{THIRD_DIFFERENCE_VARIANCE, mean, third_differences};

/// The standard deviation of the noise of each fitted channel, by [`noise_deviation`] of its row means in the open part
/// of each experiment.
#[must_use]
pub fn estimated_noise<C: Candidates + ?Sized>(
    system: &C,
    open: &[OpenPart],
    settings: &NoiseSettings,
) -> Vec<f64> {
    fitted_outputs(system)
        .map(|(c, _)| {
            let series: Vec<Vec<f64>> =
                open.iter().map(|part| row_means(system, part, c)).collect();
            noise_deviation(&series, settings.relative)
        })
        .collect()
}

/// Autocovariances of an error that moves as each fitted channel does in the open parts, with a standard deviation of
/// [`discrepancy`](NoiseSettings::discrepancy) times that of the channel.
#[must_use]
pub fn moving_discrepancy<C: Candidates + ?Sized>(
    system: &C,
    open: &[OpenPart],
    settings: &NoiseSettings,
) -> Discrepancy {
    let of_channel = |(c, _)| {
        let series: Vec<Vec<f64>> = open
            .iter()
            .map(|part| {
                let rows = row_means(system, part, c);
                let centre = mean(&rows);
                rows.iter().map(|r| settings.discrepancy * (r - centre)).collect()
            })
            .collect();
        let series: Vec<&[f64]> = series.iter().map(Vec::as_slice).collect();
        autocovariance(&series, settings.order)
    };
    let channels = fitted_outputs(system).map(of_channel).collect();
    Discrepancy { covariances: Covariances::independent(channels), levels: Vec::new() }
}

/// The row means of a channel in an open part.
fn row_means<C: Candidates + ?Sized>(system: &C, part: &OpenPart, channel: usize) -> Vec<f64> {
    let points = system.points_per_row();
    let end = system.point_at(part.experiment, part.end_s);
    let measured = system.measured(part.experiment, channel)[..end].chunks_exact(points);
    measured.map(|r| r.iter().sum::<f64>() / points as f64).collect()
}

/// The standard deviation below which an error is no error: that of the noise, joined by a `relative` part of the
/// variation of the series, which stands for the errors of solver, grid and filters.
///
/// The noise is estimated from [`third_differences`]; the median of their sizes is not moved by a few jumps.
#[must_use]
pub fn noise_deviation(series: &[Vec<f64>], relative: f64) -> f64 {
    let (mut noise, mut variation) = (Vec::new(), Vec::new());
    for rows in series {
        let mut sizes: Vec<f64> = third_differences(rows).into_iter().map(f64::abs).collect();
        if sizes.is_empty() {
            continue;
        }
        let middle = sizes.len() / 2;
        let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
        noise.push(*median / (0.6745 * THIRD_DIFFERENCE_VARIANCE.sqrt()));
        let centre = mean(rows);
        let square = rows.iter().map(|r| (r - centre).powi(2)).sum::<f64>();
        variation.push((square / rows.len() as f64).sqrt());
    }
    if noise.is_empty() { 1e-9 } else { mean(&noise).hypot(relative * mean(&variation)).max(1e-9) }
}
