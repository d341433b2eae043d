//! Dry friction that is higher near standstill.

use crate::effects::{HiddenEffect, Phenomenon, SetUp, entry};
use crate::plant::DryFriction;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("stribeck_friction"),
    typical: &[12.0, 30.0, 1.5],
    build: |v| {
        Box::new(StribeckFriction(DryFriction {
            coulomb_n: v[0],
            static_n: v[1],
            velocity_mm_s: v[2],
        }))
    },
};

struct StribeckFriction(DryFriction);

impl Phenomenon for StribeckFriction {
    fn set_up(&self, setup: &mut SetUp) {
        setup.frictions.push(self.0);
    }
}
