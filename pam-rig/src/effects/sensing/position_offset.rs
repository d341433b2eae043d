//! An encoder with a wrong zero.

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon, Seen};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "position_offset",
    group: Group::Sensing,
    what: "measured displacement = true displacement + offset_mm",
    parameters: &[ParameterInfo::new("offset_mm", 0.2, [-20.0, 20.0])],
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
