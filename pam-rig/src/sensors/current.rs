//! The motor's current sensor.

use super::quantised;
use serde::{Deserialize, Serialize};

/// Parameters of the current sensor. The published excerpt of a log shows steps of 1/1024 A and a
/// spread of 0.04 A at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CurrentParameters {
    /// Standard deviation of a reading, A.
    pub noise_a: f64,
    /// Resolution, A; 0 = ideal.
    pub step_a: f64,
    /// Reading at no current, A.
    pub offset_a: f64,
}

impl Default for CurrentParameters {
    fn default() -> Self {
        Self { noise_a: 0.04, step_a: 1.0 / 1024.0, offset_a: 0.0 }
    }
}

impl CurrentParameters {
    /// A reading; `normal` is a standard normal number.
    #[must_use]
    pub fn read_a(&self, current_a: f64, normal: f64) -> f64 {
        quantised(current_a + self.offset_a + self.noise_a * normal, self.step_a)
    }
}
