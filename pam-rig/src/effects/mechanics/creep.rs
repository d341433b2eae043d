//! Slow viscoelastic relaxation.

use crate::effects::{Clock, HiddenEffect, Phenomenon, entry};
use crate::plant::Plant;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("creep"),
    typical: &[20.0, 5.0],
    build: |v| Box::new(Creep { stiffness_n_mm: v[0], time_constant_s: v[1], damper_mm: None }),
};

/// Force −k (x − q), with the damper's end q following x with the time constant.
struct Creep {
    stiffness_n_mm: f64,
    time_constant_s: f64,
    damper_mm: Option<f64>,
}

impl Phenomenon for Creep {
    fn joint_force_n(&mut self, clock: &Clock, plant: &Plant) -> f64 {
        let x = plant.displacement_mm();
        let q = self.damper_mm.get_or_insert(x);
        *q = x + (*q - x) * (-clock.step_s / self.time_constant_s).exp();
        -self.stiffness_n_mm * (x - *q)
    }
}
