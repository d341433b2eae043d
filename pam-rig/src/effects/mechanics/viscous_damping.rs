//! Extra force proportional to ẋ.

use crate::effects::{HiddenEffect, Phenomenon, SetUp, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("viscous_damping"),
    typical: &[2000.0],
    build: |v| Box::new(ViscousDamping { coefficient_ns_m: v[0] }),
};

struct ViscousDamping {
    coefficient_ns_m: f64,
}

impl Phenomenon for ViscousDamping {
    fn set_up(&self, setup: &mut SetUp) {
        setup.plant.viscous_ns_m += self.coefficient_ns_m;
    }
}
