//! The restoring force changes slowly with time.

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "stiffness_drift",
    group: Group::Mechanics,
    what: "the muscles' net force grows by a share every minute of the excitation",
    parameters: &[ParameterInfo::new("relative_per_min", 0.1, [-0.9, 10.0])],
    build: |v| Box::new(StiffnessDrift { relative_per_min: v[0] }),
};

struct StiffnessDrift {
    relative_per_min: f64,
}

impl Phenomenon for StiffnessDrift {
    fn muscle_scale(&self, clock: &Clock) -> f64 {
        1.0 + self.relative_per_min * clock.time_s.max(0.0) / 60.0
    }
}
