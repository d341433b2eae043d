//! Pressure sensors with a wrong gain.

use crate::effects::{Clock, HiddenEffect, Phenomenon, Seen, entry};
use pam_core::units::ATMOSPHERE_KPA;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("pressure_gain"),
    typical: &[0.05, -0.03],
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
