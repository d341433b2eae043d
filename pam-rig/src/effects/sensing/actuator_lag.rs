//! The real force follows the commanded one through a first-order low-pass.

use crate::effects::{Clock, HiddenEffect, Phenomenon, entry};
use std::f64::consts::TAU;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("actuator_lag"),
    typical: &[3.0],
    build: |v| Box::new(ActuatorLag { cutoff_hz: v[0], force_n: None }),
};

struct ActuatorLag {
    cutoff_hz: f64,
    /// Force at the end of the last step.
    force_n: Option<f64>,
}

impl Phenomenon for ActuatorLag {
    /// The command is held for a step: `F(t) = u + (F₀ − u) exp(−2π f t)`, of which the joint feels the mean.
    fn actuate(&mut self, clock: &Clock, force_n: f64) -> f64 {
        let start = *self.force_n.get_or_insert(force_n);
        let steps = TAU * self.cutoff_hz * clock.step_s;
        let gone = -(-steps).exp_m1();
        self.force_n = Some(start + gone * (force_n - start));
        force_n + (start - force_n) * gone / steps
    }
}
