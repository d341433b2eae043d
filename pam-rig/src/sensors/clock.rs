//! The sample clock.

use serde::{Deserialize, Serialize};

/// Parameters of the clock. Frames are numbered as if it were exact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ClockParameters {
    /// Nominal samples per second.
    pub rate_hz: f64,
    /// Relative error of the clock, ppm; positive if it runs slow.
    pub skew_ppm: f64,
    /// Standard deviation of the time at which the encoder is read, µs.
    pub jitter_us: f64,
}

impl Default for ClockParameters {
    fn default() -> Self {
        Self { rate_hz: 1000.0, skew_ppm: 20.0, jitter_us: 5.0 }
    }
}

impl ClockParameters {
    /// True time between samples, s.
    #[must_use]
    pub fn sample_s(&self) -> f64 {
        (1.0 + 1e-6 * self.skew_ppm) / self.rate_hz
    }
}
