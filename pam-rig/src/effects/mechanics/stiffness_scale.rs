//! The restoring force is off by a constant factor.

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "stiffness_scale",
    group: Group::Mechanics,
    what: "the muscles' net force is off by a constant factor",
    parameters: &[ParameterInfo::new("relative", 0.15, [-0.9, 10.0])],
    build: |v| Box::new(StiffnessScale { relative: v[0] }),
};

struct StiffnessScale {
    relative: f64,
}

impl Phenomenon for StiffnessScale {
    fn muscle_scale(&self, _clock: &Clock) -> f64 {
        1.0 + self.relative
    }
}
