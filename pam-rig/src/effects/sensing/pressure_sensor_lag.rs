//! A first-order low-pass on both pressure channels.

use crate::effects::{Clock, HiddenEffect, Phenomenon, Seen, entry};
use std::f64::consts::TAU;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("pressure_sensor_lag"),
    typical: &[3.0],
    build: |v| Box::new(PressureSensorLag { cutoff_hz: v[0], state_kpa: None }),
};

struct PressureSensorLag {
    cutoff_hz: f64,
    state_kpa: Option<[f64; 2]>,
}

impl Phenomenon for PressureSensorLag {
    fn observe(&mut self, clock: &Clock, seen: &mut Seen) {
        let state = self.state_kpa.get_or_insert(seen.pressures_kpa);
        let share = -(-TAU * self.cutoff_hz * clock.step_s).exp_m1();
        for (s, p) in state.iter_mut().zip(&mut seen.pressures_kpa) {
            *s += share * (*p - *s);
            *p = *s;
        }
    }
}
