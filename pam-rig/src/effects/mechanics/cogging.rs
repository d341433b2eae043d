//! Force periodic in position.

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon};
use crate::plant::Plant;
use std::f64::consts::TAU;

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "cogging",
    group: Group::Mechanics,
    what: "force −force_n sin(2π x / pitch_mm), periodic in position",
    parameters: &[
        ParameterInfo::new("force_n", 10.0, [-500.0, 500.0]),
        ParameterInfo::new("pitch_mm", 0.6, [1e-3, 100.0]),
    ],
    build: |v| Box::new(Cogging { force_n: v[0], pitch_mm: v[1] }),
};

struct Cogging {
    force_n: f64,
    pitch_mm: f64,
}

impl Phenomenon for Cogging {
    fn joint_force_n(&mut self, _clock: &Clock, plant: &Plant) -> f64 {
        -self.force_n * (TAU * plant.displacement_mm() / self.pitch_mm).sin()
    }
}
