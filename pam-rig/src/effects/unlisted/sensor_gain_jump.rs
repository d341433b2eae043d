//! A pressure sensor whose gain jumps.

use crate::effects::{Clock, EffectInfo, Group, HiddenEffect, ParameterInfo, Phenomenon, Seen};
use pam_core::units::ATMOSPHERE_KPA;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: &EffectInfo::new(
        "sensor_gain_jump",
        Group::Sensing,
        "flexor's pressure sensor whose gain jumps",
        &[
            ParameterInfo::linear("time_s", [0.0, 1e5]).off_at(None).meaning("time of the jump"),
            ParameterInfo::linear("relative", [-0.9, 5.0])
                .meaning("from then on measured = (1 + relative) · true gauge pressure"),
        ],
    ),
    typical: &[23.0, 0.06],
    build: |v| Box::new(SensorGainJump { time_s: v[0], relative: v[1] }),
};

struct SensorGainJump {
    time_s: f64,
    relative: f64,
}

impl Phenomenon for SensorGainJump {
    fn observe(&mut self, clock: &Clock, seen: &mut Seen) {
        if clock.time_s >= self.time_s {
            seen.pressures_kpa[0] += self.relative * (seen.pressures_kpa[0] - ATMOSPHERE_KPA);
        }
    }
}
