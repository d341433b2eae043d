//! The rig's pulse servo.

use super::valve::Opening;
use serde::{Deserialize, Serialize};

/// Parameters of the servo (Wang and Realmuto 2026, section IV; the deadband is not published).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ServoParameters {
    /// Largest error that starts no pulse, psi.
    pub deadband_psi: f64,
    /// Length of an inflation pulse, ms.
    pub inflate_ms: f64,
    /// Length of an exhaust pulse, ms.
    pub exhaust_ms: f64,
    /// Pause after every pulse, ms.
    pub refractory_ms: f64,
}

impl Default for ServoParameters {
    fn default() -> Self {
        Self { deadband_psi: 0.5, inflate_ms: 10.0, exhaust_ms: 15.0, refractory_ms: 20.0 }
    }
}

/// The servo of one muscle: outside the deadband a pulse, then a pause; inside both valves shut. It is
/// called once per sample.
#[derive(Debug, Clone, Copy)]
pub struct Servo {
    parameters: ServoParameters,
    opening: Opening,
    pulse_left_ms: f64,
    pause_left_ms: f64,
}

impl Servo {
    /// A servo at rest.
    #[must_use]
    pub fn new(parameters: ServoParameters) -> Self {
        Self { parameters, opening: Opening::Shut, pulse_left_ms: 0.0, pause_left_ms: 0.0 }
    }

    /// Openings of the valves until the next sample, `sample_ms` later.
    pub fn decide(&mut self, target_psi: f64, measured_psi: f64, sample_ms: f64) -> Opening {
        // Half a sample of tolerance, so that pulses last the same number of samples every time.
        let tolerance = 0.5 * sample_ms;
        if self.pulse_left_ms > tolerance {
            self.pulse_left_ms -= sample_ms;
            return self.opening;
        }
        if self.opening != Opening::Shut {
            self.opening = Opening::Shut;
            self.pause_left_ms = self.parameters.refractory_ms;
        }
        if self.pause_left_ms > tolerance {
            self.pause_left_ms -= sample_ms;
            return Opening::Shut;
        }
        let error = target_psi - measured_psi;
        if error.abs() <= self.parameters.deadband_psi {
            return Opening::Shut;
        }
        let (opening, length) = if error > 0.0 {
            (Opening::Inflate, self.parameters.inflate_ms)
        } else {
            (Opening::Exhaust, self.parameters.exhaust_ms)
        };
        self.opening = opening;
        self.pulse_left_ms = length - sample_ms;
        opening
    }

    /// Shuts the valves and forgets the pulse.
    pub fn rest(&mut self) {
        *self = Self::new(self.parameters);
    }
}
