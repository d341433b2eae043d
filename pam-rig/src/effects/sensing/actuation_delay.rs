//! The real force follows the recorded one later.

use super::DelayLine;
use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "actuation_delay",
    group: Group::Sensing,
    what: "real force follows the recorded one later",
    parameters: &[ParameterInfo::new("delay_ms", 15.0, [0.0, 1e3])],
    build: |v| Box::new(ActuationDelay(DelayLine::new(1e-3 * v[0]))),
};

struct ActuationDelay(DelayLine);

impl Phenomenon for ActuationDelay {
    fn actuate(&mut self, clock: &Clock, force_n: f64) -> f64 {
        self.0.pass(force_n, clock.step_s)
    }
}
