//! A force of its own frequency, as from a machine on the same table.

use crate::effects::{Clock, EffectInfo, Group, HiddenEffect, ParameterInfo, Phenomenon};
use crate::plant::Plant;
use std::f64::consts::TAU;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: &EffectInfo::new(
        "periodic_disturbance",
        Group::Mechanics,
        "periodic force on the joint that is unrelated to the excitation",
        &[
            ParameterInfo::linear("force_n", [0.0, 500.0])
                .meaning("amplitude of the force `force_n · sin(2π frequency_hz t)`"),
            ParameterInfo::scale("frequency_hz", [1e-3, 200.0]).meaning("frequency"),
        ],
    ),
    typical: &[12.0, 1.37],
    build: |v| Box::new(PeriodicDisturbance { force_n: v[0], frequency_hz: v[1] }),
};

struct PeriodicDisturbance {
    force_n: f64,
    frequency_hz: f64,
}

impl Phenomenon for PeriodicDisturbance {
    fn joint_force_n(&mut self, clock: &Clock, _plant: &Plant) -> f64 {
        self.force_n * (TAU * self.frequency_hz * clock.time_s).sin()
    }
}
