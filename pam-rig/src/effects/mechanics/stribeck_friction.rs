//! Dry friction that is higher near standstill.

use crate::effects::{EffectInfo, Group, ParameterInfo, Phenomenon, SetUp};
use crate::plant::DryFriction;

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "stribeck_friction",
    group: Group::Mechanics,
    what: "more dry friction, higher near standstill: coulomb + (static − coulomb) exp(−(v/velocity)²)",
    parameters: &[
        ParameterInfo::new("coulomb_n", 12.0, [0.0, 500.0]),
        ParameterInfo::new("static_n", 30.0, [0.0, 500.0]),
        ParameterInfo::new("velocity_mm_s", 1.5, [0.01, 100.0]),
    ],
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
