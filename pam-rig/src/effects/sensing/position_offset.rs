//! An encoder with a wrong zero.

use crate::effects::{Clock, HiddenEffect, Phenomenon, Seen, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("position_offset"),
    typical: &[0.2],
    build: |v| Box::new(PositionOffset { offset_mm: v[0] }),
};

struct PositionOffset {
    offset_mm: f64,
}

impl Phenomenon for PositionOffset {
    fn observe(&mut self, _clock: &Clock, seen: &mut Seen) {
        seen.displacement_mm += self.offset_mm;
    }
}
