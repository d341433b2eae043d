//! Force periodic in position.

use crate::effects::{Clock, HiddenEffect, Phenomenon, entry};
use crate::plant::Plant;
use std::f64::consts::TAU;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("cogging"),
    typical: &[10.0, 0.6],
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
