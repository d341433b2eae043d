//! A steady force on the joint.

use crate::effects::{Clock, HiddenEffect, Phenomenon, entry};
use crate::plant::Plant;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("constant_load"),
    typical: &[20.0],
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
