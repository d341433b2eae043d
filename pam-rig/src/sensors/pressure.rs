//! Pressure sensors with their on-board low-pass.

use super::quantised;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Parameters of a pressure sensor (Honeywell 150PG2A3: 150 psi over 80 % of 14 bits), with the
/// controller's 3 Hz low-pass (Wang and Realmuto 2026, section V).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PressureParameters {
    /// Cutoff of the first-order low-pass, Hz; 0 = none.
    pub cutoff_hz: f64,
    /// Resolution before the filter, psi; 0 = ideal.
    pub step_psi: f64,
    /// Standard deviation of a reading before the filter, psi.
    pub noise_psi: f64,
}

impl Default for PressureParameters {
    fn default() -> Self {
        Self { cutoff_hz: 3.0, step_psi: 150.0 / (0.8 * 16384.0), noise_psi: 0.008 }
    }
}

/// One sensor in use.
#[derive(Debug, Clone, Copy)]
pub struct PressureSensor {
    parameters: PressureParameters,
    share: f64,
    filtered_psi: Option<f64>,
}

impl PressureSensor {
    /// A sensor read every `sample_s`.
    #[must_use]
    pub fn new(parameters: PressureParameters, sample_s: f64) -> Self {
        let share = if parameters.cutoff_hz > 0.0 {
            -(-TAU * parameters.cutoff_hz * sample_s).exp_m1()
        } else {
            1.0
        };
        Self { parameters, share, filtered_psi: None }
    }

    /// Reads a gauge pressure: before and after the low-pass, psi. `normal` is a standard normal
    /// number.
    pub fn read_psi(&mut self, gauge_psi: f64, normal: f64) -> (f64, f64) {
        let p = &self.parameters;
        let raw = quantised(gauge_psi + p.noise_psi * normal, p.step_psi);
        let filtered = self.filtered_psi.get_or_insert(raw);
        *filtered += self.share * (raw - *filtered);
        (raw, *filtered)
    }
}
