//! The real force is off by a factor.

use crate::effects::{Clock, HiddenEffect, Phenomenon, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("force_gain"),
    typical: &[-0.1],
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
