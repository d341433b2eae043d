//! Dry friction that grows with the tension of the tendons.

use crate::effects::{Clock, HiddenEffect, Phenomenon, entry};
use crate::plant::Plant;
use pam_core::units::ATMOSPHERE_KPA;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("load_friction"),
    typical: &[0.08],
    build: |v| Box::new(LoadFriction { force_n_per_kpa: v[0] }),
};

struct LoadFriction {
    force_n_per_kpa: f64,
}

impl Phenomenon for LoadFriction {
    fn dry_friction_n(&self, _clock: &Clock, plant: &Plant) -> f64 {
        let [flexor, extensor] = plant.pressures_kpa();
        let gauge_kpa = 0.5 * (flexor + extensor) - ATMOSPHERE_KPA;
        self.force_n_per_kpa * gauge_kpa.max(0.0)
    }
}
