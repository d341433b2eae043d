//! Extra force proportional to ẋ.

use crate::effects::{EffectInfo, Group, ParameterInfo, Phenomenon, SetUp};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "viscous_damping",
    group: Group::Mechanics,
    what: "more force proportional to the velocity",
    parameters: &[ParameterInfo::new("coefficient_ns_m", 2000.0, [0.0, 1e5])],
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
