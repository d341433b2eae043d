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

use pam_core::NamedChoice;
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

impl NamedChoice for Part {
    const KIND: &'static str = "part";
    const ALL: &'static [(&'static str, Self, &'static str)] = &[
        ("motor", Self::Motor, "commanded current without quantisation"),
        ("encoder", Self::Encoder, "encoder without quantisation"),
        ("pressure-lag", Self::PressureLag, "pressure sensors without low-pass"),
        ("pressure-noise", Self::PressureNoise, "pressure sensors without quantisation and noise"),
        ("current", Self::Current, "current sensor without quantisation and noise"),
        ("clock", Self::Clock, "sampling without jitter"),
    ];
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
        Part::ALL.iter().fold(self, |sensors, (_, part, _)| sensors.with_ideal(*part))
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
