//! An encoder with a wrong gain (or a wrong pulley radius).

use crate::effects::{Clock, HiddenEffect, Phenomenon, Seen, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("position_gain"),
    typical: &[0.05],
    build: |v| Box::new(PositionGain { relative: v[0] }),
};

struct PositionGain {
    relative: f64,
}

impl Phenomenon for PositionGain {
    fn observe(&mut self, _clock: &Clock, seen: &mut Seen) {
        seen.displacement_mm *= 1.0 + self.relative;
    }
}
