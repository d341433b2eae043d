//! Pressure sensors with an offset.

use crate::effects::{Clock, HiddenEffect, Phenomenon, Seen, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("pressure_bias"),
    typical: &[8.0, -5.0],
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
