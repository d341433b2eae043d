//! A steady force on the joint.

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon};
use crate::plant::Plant;

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "constant_load",
    group: Group::Mechanics,
    what: "steady force in the direction of +x (gravity, imbalance, preload)",
    parameters: &[ParameterInfo::new("force_n", 20.0, [-500.0, 500.0])],
    build: |v| Box::new(ConstantLoad { force_n: v[0] }),
};

struct ConstantLoad {
    force_n: f64,
}

impl Phenomenon for ConstantLoad {
    fn joint_force_n(&mut self, _clock: &Clock, _plant: &Plant) -> f64 {
        self.force_n
    }
}
