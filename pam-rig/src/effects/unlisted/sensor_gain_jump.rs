//! A pressure sensor whose gain jumps.

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon, Seen};
use pam_core::units::ATMOSPHERE_KPA;

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "sensor_gain_jump",
    group: Group::Unlisted,
    what: "from time_s on the flexor's sensor reads gauge pressures off by a factor",
    parameters: &[
        ParameterInfo::new("time_s", 23.0, [0.0, 1e5]),
        ParameterInfo::new("relative", 0.06, [-0.9, 5.0]),
    ],
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
