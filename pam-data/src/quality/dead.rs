//! Channels that never change.

use super::channel::ChannelQuality;
use super::{QualityFinding, QualityKind};
use crate::plausibility::Severity;
use crate::recording::Recording;

/// A channel that is constant although the joint moves. Forces may be zero in free motion.
pub(super) fn finding(c: &ChannelQuality, r: &Recording) -> Option<QualityFinding> {
    if !c.is_constant() {
        return None;
    }
    let range = |v: &[f64]| {
        v.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            - v.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let moves = range(&r.displacement_mm) > 0.0;
    let (severity, why) = match (c.column, moves) {
        ("force_n", true) => (
            Severity::Warning,
            "the motion is free, or the sensor is dead: stiffness and friction then follow from the decay alone",
        ),
        (_, true) => (
            Severity::Error,
            "while the joint moves: the sensor or its cable is dead, or the column is another one",
        ),
        _ => (Severity::Warning, "nothing moves in this recording"),
    };
    let message = format!("{} is {} {} throughout; {why}", c.column, c.mean, c.unit);
    Some(QualityFinding::new(QualityKind::Dead, severity, c.column, message))
}
