//! Pressure sensors with a wrong gain.

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon, Seen};
use pam_core::units::ATMOSPHERE_KPA;

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "pressure_gain",
    group: Group::Sensing,
    what: "measured gauge pressure = (1 + relative) · true gauge pressure",
    parameters: &[
        ParameterInfo::new("flexor_relative", 0.05, [-0.9, 5.0]).or(0.0),
        ParameterInfo::new("extensor_relative", -0.03, [-0.9, 5.0]).or(0.0),
    ],
    build: |v| Box::new(PressureGain([v[0], v[1]])),
};

struct PressureGain([f64; 2]);

impl Phenomenon for PressureGain {
    fn observe(&mut self, _clock: &Clock, seen: &mut Seen) {
        for (p, relative) in seen.pressures_kpa.iter_mut().zip(self.0) {
            *p += relative * (*p - ATMOSPHERE_KPA);
        }
    }
}
