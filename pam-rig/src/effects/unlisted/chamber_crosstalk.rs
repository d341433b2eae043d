//! Air that flows between the chambers.

use crate::effects::{Clock, EffectInfo, Group, HiddenEffect, ParameterInfo, Phenomenon};
use crate::plant::Plant;
use crate::plant::gas::{GAS_CONSTANT, ROOM_K};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: &EffectInfo::new(
        "chamber_crosstalk",
        Group::Gas,
        "air that flows between the sealed chambers through a narrow passage",
        &[ParameterInfo::linear("rate_per_s", [0.0, 1.0])
            .meaning("flow `d(P V)/dt = rate_per_s · V · (P_other − P)` into a chamber")],
    ),
    typical: &[4e-3],
    build: |v| Box::new(ChamberCrosstalk { rate_per_s: v[0] }),
};

struct ChamberCrosstalk {
    rate_per_s: f64,
}

impl Phenomenon for ChamberCrosstalk {
    fn air_g(&mut self, clock: &Clock, plant: &Plant) -> [f64; 2] {
        if clock.sealed_g.is_none() {
            return [0.0; 2];
        }
        let [flexor, extensor] = plant.muscles();
        let volume = 0.5 * (flexor.air.volume_mm3() + extensor.air.volume_mm3());
        let difference = extensor.air.pressure_kpa() - flexor.air.pressure_kpa();
        let into_flexor =
            self.rate_per_s * clock.step_s * difference * volume / (GAS_CONSTANT * ROOM_K);
        [into_flexor, -into_flexor]
    }
}
