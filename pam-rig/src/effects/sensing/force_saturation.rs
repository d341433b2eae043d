//! The real force is clipped.

use crate::effects::{Clock, HiddenEffect, Phenomenon, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("force_saturation"),
    typical: &[160.0],
    build: |v| Box::new(ForceSaturation { force_n: v[0] }),
};

struct ForceSaturation {
    force_n: f64,
}

impl Phenomenon for ForceSaturation {
    fn actuate(&mut self, _clock: &Clock, force_n: f64) -> f64 {
        force_n.clamp(-self.force_n, self.force_n)
    }
}
