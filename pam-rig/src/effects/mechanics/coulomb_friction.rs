//! Dry friction opposing ẋ, with sticking.

use crate::effects::{EffectInfo, Group, ParameterInfo, Phenomenon, SetUp};
use crate::plant::DryFriction;

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "coulomb_friction",
    group: Group::Mechanics,
    what: "more dry friction of joint and gearbox, opposing the motion, with sticking",
    parameters: &[ParameterInfo::new("force_n", 20.0, [0.0, 500.0])],
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
