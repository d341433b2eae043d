//! Beyond a displacement one tendon is slack.

use crate::effects::{Clock, HiddenEffect, Phenomenon, SetUp, entry};
use crate::plant::Plant;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("tendon_slack"),
    typical: &[1.0, 0.4],
    build: |v| Box::new(TendonSlack { displacement_mm: v[0], stiffness_loss: v[1] }),
};

/// Beyond the displacement, the volume of the shortening muscle stays constant, and the elastic restoring force is lower by
/// `loss · (f(x) − f(±displacement))`, where f is the force without the effect. The constant volume keeps the pressure in
/// that muscle higher, which lowers the restoring force as well; the loss includes this part.
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
        let whole = force(x);
        let lost = self.stiffness_loss * (whole - force(self.displacement_mm.copysign(x)));
        let lost_to_pressure = whole - plant.elastic_restoring_force_n(x, masses);
        lost - lost_to_pressure
    }
}
