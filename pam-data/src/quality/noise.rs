//! Noise without a model: what changes from sample to sample.

use super::channel::ChannelQuality;
use super::settings::QualitySettings;
use super::{QualityFinding, QualityKind};
use crate::plausibility::Severity;
use pam_numerics::statistics::{THIRD_DIFFERENCE_VARIANCE, root_mean_square, third_differences};

/// Standard deviation of the white noise, from [`third_differences`].
pub(super) fn white(values: &[f64]) -> f64 {
    let third = third_differences(values);
    if third.is_empty() { 0.0 } else { root_mean_square(&third) / THIRD_DIFFERENCE_VARIANCE.sqrt() }
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
