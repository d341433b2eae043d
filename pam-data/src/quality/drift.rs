//! Levels that wander.

use super::channel::ChannelQuality;
use super::settings::QualitySettings;
use super::{QualityFinding, QualityKind};
use crate::plausibility::Severity;
use pam_numerics::statistics::mean;

/// Mean of the last tenth less that of the first.
pub(super) fn change(values: &[f64]) -> f64 {
    let tenth = (values.len() / 10).max(1);
    mean(&values[values.len() - tenth..]) - mean(&values[..tenth])
}

pub(super) fn finding(c: &ChannelQuality, s: &QualitySettings) -> Option<QualityFinding> {
    // Motion and force may end elsewhere; sealed air may not.
    if !c.column.starts_with("pressure") || c.drift.abs() <= s.drift_share * c.range() {
        return None;
    }
    let message = format!(
        "{} ends {:.2} {} {} than it starts, {:.0} % of its range: a leak, warming air, or another resting position",
        c.column,
        c.drift.abs(),
        c.unit,
        if c.drift > 0.0 { "higher" } else { "lower" },
        100.0 * c.drift.abs() / c.range()
    );
    Some(QualityFinding::new(QualityKind::Drift, Severity::Warning, c.column, message))
}
