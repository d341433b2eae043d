//! The motor that pushes the joint.

use super::quantised;
use pam_core::units::{GEAR_RATIO, PULLEY_RADIUS_MM, TORQUE_CONSTANT_MNM_PER_A};
use serde::{Deserialize, Serialize};

/// Counts of the converter at no current.
pub const COMMAND_ZERO: f64 = 2047.0;

/// Parameters of motor, amplifier and gear.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotorParameters {
    /// Torque constant, mN·m/A.
    pub torque_constant_mnm_a: f64,
    /// Gear ratio.
    pub gear_ratio: f64,
    /// Current of one count of the 12-bit command (0 = ideal), A.
    pub command_step_a: f64,
}

impl Default for MotorParameters {
    fn default() -> Self {
        Self {
            torque_constant_mnm_a: TORQUE_CONSTANT_MNM_PER_A,
            gear_ratio: GEAR_RATIO,
            command_step_a: 3.0 / 2047.0,
        }
    }
}

impl MotorParameters {
    /// The real current for a commanded one.
    #[must_use]
    pub fn current_a(&self, wanted_a: f64) -> f64 {
        quantised(wanted_a, self.command_step_a)
    }

    /// The command for a current, counts.
    #[must_use]
    pub fn command(&self, current_a: f64) -> f64 {
        let step = if self.command_step_a > 0.0 { self.command_step_a } else { 3.0 / 2047.0 };
        COMMAND_ZERO + current_a / step
    }

    /// Force at the tendon of a current, N (1 A is 133.5 N).
    #[must_use]
    pub fn force_n(&self, current_a: f64) -> f64 {
        current_a * self.torque_constant_mnm_a * self.gear_ratio / PULLEY_RADIUS_MM
    }
}
