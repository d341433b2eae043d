//! A pure delay on both pressure channels.

use super::DelayLine;
use crate::effects::{Clock, HiddenEffect, Phenomenon, Seen, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("pressure_delay"),
    typical: &[40.0],
    build: |v| Box::new(PressureDelay([0, 1].map(|_| DelayLine::new(1e-3 * v[0])))),
};

struct PressureDelay([DelayLine; 2]);

impl Phenomenon for PressureDelay {
    fn observe(&mut self, clock: &Clock, seen: &mut Seen) {
        for (line, p) in self.0.iter_mut().zip(&mut seen.pressures_kpa) {
            *p = line.pass(*p, clock.step_s);
        }
    }
}
