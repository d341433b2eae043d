//! Noise of each channel, from the data alone.

use crate::fit::{CHANNELS, Floors};
use pam_effects::simulation::Trial;

/// A model is not asked to be better than this share of a channel's own variation.
const RELATIVE_FLOOR: f64 = 4e-3;

/// The level below which an error is no error, for each fitted channel: the noise of a row mean, joined by
/// 0.4 % of the channel's variation, which stands for what solver, grid and filters leave.
///
/// The noise is read from third differences of row means, in which a motion of a few hertz has all but
/// vanished; the median of their sizes is not moved by the few rows with reversals. Their variance is
/// 20 times that of a row for independent noise.
#[must_use]
pub fn noise_floors(trials: &[&Trial]) -> Floors {
    Floors(CHANNELS.map(|c| {
        let mut noise = Vec::new();
        let mut variation = Vec::new();
        for t in trials {
            let rows: Vec<f64> =
                t.record.measured[c].chunks_exact(5).map(|r| r.iter().sum::<f64>() / 5.0).collect();
            let mut sizes: Vec<f64> =
                rows.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs()).collect();
            if sizes.is_empty() {
                continue;
            }
            let middle = sizes.len() / 2;
            let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
            noise.push(*median / (0.6745 * 20.0_f64.sqrt()));
            let mean = rows.iter().sum::<f64>() / rows.len() as f64;
            let square = rows.iter().map(|r| (r - mean).powi(2)).sum::<f64>();
            variation.push((square / rows.len() as f64).sqrt());
        }
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
        mean(&noise).hypot(RELATIVE_FLOOR * mean(&variation)).max(1e-9)
    }))
}
