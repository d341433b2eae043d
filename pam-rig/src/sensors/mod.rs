//! Motor, encoder, pressure and current sensors, and the sample clock. Each can be made ideal.

pub mod clock;
pub mod current;
pub mod encoder;
pub mod motor;
pub mod pressure;

pub use clock::ClockParameters;
pub use current::CurrentParameters;
pub use encoder::EncoderParameters;
pub use motor::MotorParameters;
pub use pressure::{PressureParameters, PressureSensor};

use serde::{Deserialize, Serialize};

/// Parameters of motor, sensors and clock.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SensorParameters {
    /// The motor and its amplifier.
    pub motor: MotorParameters,
    /// The encoder.
    pub encoder: EncoderParameters,
    /// The pressure sensors.
    pub pressure: PressureParameters,
    /// The current sensor.
    pub current: CurrentParameters,
    /// The sample clock.
    pub clock: ClockParameters,
}

/// A part that can be made ideal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Commanded current without steps.
    Motor,
    /// Encoder without steps.
    Encoder,
    /// Pressure sensors without the on-board low-pass.
    PressureLag,
    /// Pressure sensors without steps and noise.
    PressureNoise,
    /// Current sensor without steps and noise.
    Current,
    /// Samples exactly on time.
    Clock,
}

impl Part {
    /// All parts with their names.
    pub const ALL: [(&'static str, Self); 6] = [
        ("motor", Self::Motor),
        ("encoder", Self::Encoder),
        ("pressure-lag", Self::PressureLag),
        ("pressure-noise", Self::PressureNoise),
        ("current", Self::Current),
        ("clock", Self::Clock),
    ];

    /// The part of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(n, _)| *n == name).map(|(_, part)| *part)
    }
}

impl SensorParameters {
    /// Everything ideal.
    #[must_use]
    pub fn ideal() -> Self {
        Self::default().all_ideal()
    }

    /// The same with all parts ideal.
    #[must_use]
    pub fn all_ideal(self) -> Self {
        Part::ALL.iter().fold(self, |sensors, (_, part)| sensors.with_ideal(*part))
    }

    /// The same with one part ideal.
    #[must_use]
    pub fn with_ideal(mut self, part: Part) -> Self {
        match part {
            Part::Motor => self.motor.command_step_a = 0.0,
            Part::Encoder => self.encoder.step_deg = 0.0,
            Part::PressureLag => self.pressure.cutoff_hz = 0.0,
            Part::PressureNoise => {
                self.pressure.noise_psi = 0.0;
                self.pressure.step_psi = 0.0;
            }
            Part::Current => {
                self.current.noise_a = 0.0;
                self.current.step_a = 0.0;
                self.current.offset_a = 0.0;
            }
            Part::Clock => {
                self.clock.jitter_us = 0.0;
                self.clock.skew_ppm = 0.0;
            }
        }
        self
    }
}

/// Rounds to multiples of a step; a step of zero leaves the value as it is.
#[must_use]
pub(crate) fn quantised(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}
