//! The real force is off by a factor.

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "force_gain",
    group: Group::Sensing,
    what: "real force = (1 + relative) · commanded force",
    parameters: &[ParameterInfo::new("relative", -0.1, [-1.0, 10.0])],
    build: |v| Box::new(ForceGain { relative: v[0] }),
};

struct ForceGain {
    relative: f64,
}

impl Phenomenon for ForceGain {
    fn actuate(&mut self, _clock: &Clock, force_n: f64) -> f64 {
        (1.0 + self.relative) * force_n
    }
}
