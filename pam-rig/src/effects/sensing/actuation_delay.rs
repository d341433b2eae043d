//! The real force follows the recorded one later.

use super::DelayLine;
use crate::effects::{Clock, HiddenEffect, Phenomenon, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("actuation_delay"),
    typical: &[15.0],
    build: |v| Box::new(ActuationDelay(DelayLine::new(1e-3 * v[0]))),
};

struct ActuationDelay(DelayLine);

impl Phenomenon for ActuationDelay {
    fn actuate(&mut self, clock: &Clock, force_n: f64) -> f64 {
        self.0.pass(force_n, clock.step_s)
    }
}
