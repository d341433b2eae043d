//! A first-order low-pass on the position reading.

use crate::effects::{Clock, HiddenEffect, Phenomenon, Seen, entry};
use std::f64::consts::TAU;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("position_sensor_lag"),
    typical: &[8.0],
    build: |v| Box::new(PositionSensorLag { cutoff_hz: v[0], state_mm: None }),
};

struct PositionSensorLag {
    cutoff_hz: f64,
    state_mm: Option<f64>,
}

impl Phenomenon for PositionSensorLag {
    fn observe(&mut self, clock: &Clock, seen: &mut Seen) {
        let state = self.state_mm.get_or_insert(seen.displacement_mm);
        *state -= (-TAU * self.cutoff_hz * clock.step_s).exp_m1() * (seen.displacement_mm - *state);
        seen.displacement_mm = *state;
    }
}
