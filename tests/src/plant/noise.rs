//! Rate, steps and noise of the sensors.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The correlation of a noise in time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Colour {
    /// Independent from sample to sample.
    White,
    /// First-order low-pass of white noise with this cutoff, Hz.
    LowPassed(f64),
    /// Autoregression of first order with this correlation time, s.
    Correlated(f64),
}

impl Colour {
    /// Correlation of samples that are `step_s` apart.
    #[must_use]
    pub fn correlation(self, step_s: f64) -> f64 {
        match self {
            Self::White => 0.0,
            Self::LowPassed(cutoff_hz) => (-TAU * cutoff_hz * step_s).exp(),
            Self::Correlated(time_s) => (-step_s / time_s).exp(),
        }
    }
}

/// A stationary Gaussian noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Standard deviation, in the unit of its channel.
    pub deviation: f64,
    /// Correlation.
    pub colour: Colour,
}

impl Noise {
    /// Independent samples of this standard deviation.
    #[must_use]
    pub fn white(deviation: f64) -> Self {
        Self { deviation, colour: Colour::White }
    }

    /// The noise with another standard deviation.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { deviation: factor * self.deviation, ..self }
    }
}

/// Rate, steps and noise of the sensors, and what the loader makes of their samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sensors {
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Encoder step, mm; 0 for none.
    pub encoder_mm: f64,
    /// Noise of the displacement before the encoder's steps, mm.
    pub displacement: Noise,
    /// Noise of either pressure, kPa.
    pub pressure: Noise,
    /// Noise of the recorded force, N.
    pub force: Noise,
    /// Whether the motor follows the command between samples; else it holds the last sample.
    pub smooth_force: bool,
    /// Cutoff of the zero-phase low-pass on all columns, Hz; 0 for none.
    pub cutoff_hz: f64,
}

/// The published rig: 1 kHz, steps of 0.0878906° on a pulley of 6.875 mm, 20 Hz low-pass.
impl Default for Sensors {
    fn default() -> Self {
        Self {
            rate_hz: 1000.0,
            encoder_mm: 0.010_546,
            displacement: Noise::white(0.002),
            pressure: Noise::white(0.4),
            force: Noise::white(0.5),
            smooth_force: false,
            cutoff_hz: 20.0,
        }
    }
}

impl Sensors {
    /// All noises multiplied.
    #[must_use]
    pub fn louder(self, factor: f64) -> Self {
        Self {
            displacement: self.displacement.times(factor),
            pressure: self.pressure.times(factor),
            force: self.force.times(factor),
            ..self
        }
    }

    /// What the encoder shows.
    pub(super) fn quantised(&self, x: f64) -> f64 {
        if self.encoder_mm > 0.0 { (x / self.encoder_mm).round() * self.encoder_mm } else { x }
    }
}

/// A running noise.
#[derive(Debug, Clone)]
pub(super) struct Source {
    deviation: f64,
    correlation: f64,
    fresh: f64,
    value: f64,
}

impl Source {
    /// A noise in its stationary state.
    pub(super) fn new(noise: Noise, rate_hz: f64, random: &mut ChaCha8Rng) -> Self {
        let correlation = noise.colour.correlation(1.0 / rate_hz);
        let fresh = (1.0 - correlation * correlation).sqrt();
        Self { deviation: noise.deviation, correlation, fresh, value: normal(random) }
    }

    /// The next sample.
    pub(super) fn next(&mut self, random: &mut ChaCha8Rng) -> f64 {
        self.value = self.correlation * self.value + self.fresh * normal(random);
        self.deviation * self.value
    }
}

/// A standard normal number (Box and Muller 1958).
pub(crate) fn normal(random: &mut ChaCha8Rng) -> f64 {
    let (a, b): (f64, f64) = (random.random_range(1e-12..1.0), random.random());
    (-2.0 * a.ln()).sqrt() * (TAU * b).cos()
}
