//! An encoder with a wrong gain (or a wrong pulley radius).

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon, Seen};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "position_gain",
    group: Group::Sensing,
    what: "measured displacement = (1 + relative) · true displacement",
    parameters: &[ParameterInfo::new("relative", 0.05, [-0.9, 5.0])],
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
