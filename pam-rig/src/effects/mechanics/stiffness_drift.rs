//! The restoring force changes slowly with time.

use crate::effects::{Clock, HiddenEffect, Phenomenon, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("stiffness_drift"),
    typical: &[0.1],
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
