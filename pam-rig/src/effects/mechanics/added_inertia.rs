//! Reflected mass that a model lacks.

use crate::effects::{EffectInfo, Group, ParameterInfo, Phenomenon, SetUp};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "added_inertia",
    group: Group::Mechanics,
    what: "more reflected mass",
    parameters: &[ParameterInfo::new("mass_kg", 60.0, [-200.0, 5e3])],
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
