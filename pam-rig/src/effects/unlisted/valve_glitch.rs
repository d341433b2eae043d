//! A valve that opens for a moment although it should be shut.

use crate::effects::{Clock, EffectInfo, Group, HiddenEffect, ParameterInfo, Phenomenon};
use crate::plant::Plant;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: &EffectInfo::new(
        "valve_glitch",
        Group::Gas,
        "flexor's valve that opens for 20 ms although it should be shut",
        &[
            ParameterInfo::linear("time_s", [0.0, 1e5])
                .off_at(None)
                .meaning("time at which the valve opens"),
            ParameterInfo::linear("mass_mg", [-50.0, 50.0]).meaning("mass of the air that enters"),
        ],
    ),
    typical: &[27.0, 6.0],
    build: |v| Box::new(ValveGlitch { time_s: v[0], mass_g: 1e-3 * v[1] }),
};

const OPEN_S: f64 = 0.02;

struct ValveGlitch {
    time_s: f64,
    mass_g: f64,
}

impl Phenomenon for ValveGlitch {
    fn air_g(&mut self, clock: &Clock, _plant: &Plant) -> [f64; 2] {
        // The share of the opening that falls into this step.
        let open =
            (clock.time_s + clock.step_s).min(self.time_s + OPEN_S) - clock.time_s.max(self.time_s);
        [self.mass_g * (open / OPEN_S).max(0.0), 0.0]
    }
}
