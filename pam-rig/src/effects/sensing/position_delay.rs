//! A pure delay of the position reading.

use super::DelayLine;
use crate::effects::{Clock, HiddenEffect, Phenomenon, Seen, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("position_delay"),
    typical: &[20.0],
    build: |v| Box::new(PositionDelay(DelayLine::new(1e-3 * v[0]))),
};

struct PositionDelay(DelayLine);

impl Phenomenon for PositionDelay {
    fn observe(&mut self, clock: &Clock, seen: &mut Seen) {
        seen.displacement_mm = self.0.pass(seen.displacement_mm, clock.step_s);
    }
}
