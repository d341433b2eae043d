//! Pressure sensors with an offset.

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon, Seen};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "pressure_bias",
    group: Group::Sensing,
    what: "measured pressure = true pressure + bias",
    parameters: &[
        ParameterInfo::new("flexor_kpa", 8.0, [-200.0, 200.0]).or(0.0),
        ParameterInfo::new("extensor_kpa", -5.0, [-200.0, 200.0]).or(0.0),
    ],
    build: |v| Box::new(PressureBias([v[0], v[1]])),
};

struct PressureBias([f64; 2]);

impl Phenomenon for PressureBias {
    fn observe(&mut self, _clock: &Clock, seen: &mut Seen) {
        for (p, bias) in seen.pressures_kpa.iter_mut().zip(self.0) {
            *p += bias;
        }
    }
}
