//! Resolution of channels with levels.

use super::channel::ChannelQuality;
use super::settings::QualitySettings;
use super::{QualityFinding, QualityKind};
use crate::plausibility::Severity;
use pam_numerics::statistics::{levels, median};

/// Most levels of a channel that counts as quantised, as a share of its samples.
const MOST_LEVELS: f64 = 0.2;

/// The median distance of neighbouring levels, if the channel has few of them.
pub(super) fn resolution(values: &[f64]) -> Option<f64> {
    let gaps: Vec<f64> = levels(values).windows(2).map(|w| w[1] - w[0]).collect();
    let few = !gaps.is_empty() && (gaps.len() as f64) < MOST_LEVELS * values.len() as f64;
    few.then(|| median(&gaps))
}

pub(super) fn finding(c: &ChannelQuality, s: &QualitySettings) -> Option<QualityFinding> {
    let step = c.resolution?;
    let levels = c.range() / step;
    if levels >= s.fewest_levels {
        return None;
    }
    let message = format!(
        "{} moves in steps of {step:.4} {}, {levels:.0} over its range: finer motion is not seen, and its derivative is noise",
        c.column, c.unit
    );
    Some(QualityFinding::new(QualityKind::Quantisation, Severity::Warning, c.column, message))
}
