//! A pure delay on both pressure channels.

use super::DelayLine;
use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon, Seen};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "pressure_delay",
    group: Group::Sensing,
    what: "pure delay on both pressure channels",
    parameters: &[ParameterInfo::new("delay_ms", 40.0, [0.0, 1e3])],
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
