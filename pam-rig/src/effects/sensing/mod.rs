//! Effects in actuation and sensing.

pub mod actuation_delay;
pub mod actuator_lag;
pub mod force_gain;
pub mod force_saturation;
pub mod position_delay;
pub mod position_gain;
pub mod position_offset;
pub mod position_sensor_lag;
pub mod pressure_bias;
pub mod pressure_delay;
pub mod pressure_gain;
pub mod pressure_sensor_lag;

use std::collections::VecDeque;

/// A delay line over samples of equal distance that interpolates between them.
pub(in crate::effects) struct DelayLine {
    delay_s: f64,
    last: VecDeque<f64>,
}

impl DelayLine {
    pub(in crate::effects) fn new(delay_s: f64) -> Self {
        Self { delay_s, last: VecDeque::new() }
    }

    /// Takes the value of now and gives that of `delay_s` ago; before the first one, the first one.
    pub(in crate::effects) fn pass(&mut self, value: f64, step_s: f64) -> f64 {
        self.last.push_front(value);
        let steps = self.delay_s / step_s;
        let whole = steps.floor() as usize;
        let part = steps - steps.floor();
        self.last.truncate(whole + 2);
        let at = |i: usize| self.last.get(i).or(self.last.back()).copied().unwrap_or(value);
        at(whole) + part * (at(whole + 1) - at(whole))
    }
}
