//! The restoring force is off by a constant factor.

use crate::effects::{Clock, HiddenEffect, Phenomenon, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("stiffness_scale"),
    typical: &[0.15],
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
