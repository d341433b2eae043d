//! Dry friction opposing ẋ, with sticking.

use crate::effects::{HiddenEffect, Phenomenon, SetUp, entry};
use crate::plant::DryFriction;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("coulomb_friction"),
    typical: &[20.0],
    build: |v| Box::new(CoulombFriction { force_n: v[0] }),
};

struct CoulombFriction {
    force_n: f64,
}

impl Phenomenon for CoulombFriction {
    fn set_up(&self, setup: &mut SetUp) {
        setup.frictions.push(DryFriction::coulomb(self.force_n));
    }
}
