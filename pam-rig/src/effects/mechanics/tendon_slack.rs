//! Beyond a displacement one tendon is slack.

use crate::effects::{Clock, HiddenEffect, Phenomenon, SetUp, entry};
use crate::plant::Plant;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("tendon_slack"),
    typical: &[1.0, 0.4],
    build: |v| Box::new(TendonSlack { displacement_mm: v[0], stiffness_loss: v[1] }),
};

/// The volume of the muscle that shortens stays where it is beyond the displacement, and of the elastic restoring force
/// f of the joint without the effect the share `loss · (f(x) − f(±displacement))` is lost. The pressure that stays up in
/// that muscle lowers its force by itself; what it lowers is a part of the loss.
struct TendonSlack {
    displacement_mm: f64,
    stiffness_loss: f64,
}

impl Phenomenon for TendonSlack {
    fn set_up(&self, setup: &mut SetUp) {
        for law in &mut setup.laws {
            law.largest_contraction_mm = law.largest_contraction_mm.min(self.displacement_mm);
        }
    }

    fn joint_force_n(&mut self, _clock: &Clock, plant: &Plant) -> f64 {
        let x = plant.displacement_mm();
        if x.abs() <= self.displacement_mm {
            return 0.0;
        }
        let masses = [0, 1].map(|i| plant.muscles()[i].air.mass_g);
        let force = |x: f64| plant.elastic_restoring_force_without_limit_n(x, masses);
        let lost = self.stiffness_loss * (force(x) - force(self.displacement_mm.copysign(x)));
        let lost_to_pressure = force(x) - plant.elastic_restoring_force_n(x, masses);
        lost - lost_to_pressure
    }
}
