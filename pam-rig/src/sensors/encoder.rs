//! The joint's encoder.

use super::quantised;
use pam_core::units::PULLEY_RADIUS_MM;
use serde::{Deserialize, Serialize};

/// Parameters of the encoder (AMT203-V: 4096 positions per turn).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EncoderParameters {
    /// Resolution, deg; 0 = ideal.
    pub step_deg: f64,
    /// Radius of the pulley on which the tendon runs, mm.
    pub pulley_radius_mm: f64,
}

impl Default for EncoderParameters {
    fn default() -> Self {
        Self { step_deg: 360.0 / 4096.0, pulley_radius_mm: PULLEY_RADIUS_MM }
    }
}

impl EncoderParameters {
    /// Angle (deg) for a displacement; the encoder counts against x.
    #[must_use]
    pub fn read_deg(&self, displacement_mm: f64) -> f64 {
        quantised(-(displacement_mm / self.pulley_radius_mm).to_degrees(), self.step_deg)
    }
}
