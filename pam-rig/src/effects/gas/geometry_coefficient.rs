//! The deformation coefficient is off.

use crate::effects::{HiddenEffect, Phenomenon, SetUp, entry};
use crate::plant::Braid;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("geometry_coefficient"),
    typical: &[0.1],
    build: |v| Box::new(GeometryCoefficient { relative: v[0] }),
};

/// A chamber with `dV/V = (2 nu − 1) dc/L` has `nu = (1 + L A/V)/2` at rest; a factor of nu is an
/// exponent of the volume ratio.
struct GeometryCoefficient {
    relative: f64,
}

impl Phenomenon for GeometryCoefficient {
    fn set_up(&self, setup: &mut SetUp) {
        let muscles = [setup.plant.flexor, setup.plant.extensor];
        for (law, muscle) in setup.laws.iter_mut().zip(muscles) {
            let braid = Braid::new(&muscle.braid);
            let nu =
                0.5 * (1.0 + muscle.braid.length_mm * braid.area_mm2(0.0) / braid.volume_mm3(0.0));
            law.exponent *= (2.0 * nu * (1.0 + self.relative) - 1.0) / (2.0 * nu - 1.0);
        }
    }
}
