//! Noise without a model: what changes from sample to sample.

use super::channel::ChannelQuality;
use super::settings::QualitySettings;
use super::{QualityFinding, QualityKind};
use crate::plausibility::Severity;
use pam_numerics::statistics::root_mean_square;

/// Standard deviation of the white noise: third differences remove a parabola and raise the variance of white noise by
/// 1 + 9 + 9 + 1 = 20 (von Neumann and others 1941, for higher differences Gasser and others 1986).
pub(super) fn white(values: &[f64]) -> f64 {
    let third: Vec<f64> =
        values.windows(4).map(|w| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).collect();
    if third.is_empty() { 0.0 } else { root_mean_square(&third) / 20.0_f64.sqrt() }
}

pub(super) fn finding(c: &ChannelQuality, s: &QualitySettings) -> Option<QualityFinding> {
    if c.is_constant() || c.noise <= s.noise_share * c.deviation {
        return None;
    }
    let message = format!(
        "{} has noise of {:.3} {unit} from sample to sample, {:.0} % of its variation of {:.3} {unit}: filter it \
         (--preprocess, or `filter` in the rig file)",
        c.column,
        c.noise,
        100.0 * c.noise / c.deviation,
        c.deviation,
        unit = c.unit
    );
    Some(QualityFinding::new(QualityKind::Noise, Severity::Warning, c.column, message))
}
