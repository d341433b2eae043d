//! A force of its own frequency, as from a machine on the same table.

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon};
use crate::plant::Plant;
use std::f64::consts::TAU;

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "periodic_disturbance",
    group: Group::Unlisted,
    what: "force_n sin(2π frequency_hz t) on the joint, unrelated to the excitation",
    parameters: &[
        ParameterInfo::new("force_n", 12.0, [0.0, 500.0]),
        ParameterInfo::new("frequency_hz", 1.37, [1e-3, 200.0]),
    ],
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
