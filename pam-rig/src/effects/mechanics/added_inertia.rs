//! Reflected mass that a model lacks.

use crate::effects::{HiddenEffect, Phenomenon, SetUp, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("added_inertia"),
    typical: &[60.0],
    build: |v| Box::new(AddedInertia { mass_kg: v[0] }),
};

struct AddedInertia {
    mass_kg: f64,
}

impl Phenomenon for AddedInertia {
    fn set_up(&self, setup: &mut SetUp) {
        setup.plant.mass_kg += self.mass_kg;
    }
}
