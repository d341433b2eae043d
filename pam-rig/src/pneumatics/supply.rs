//! The reservoir that feeds both muscles.

use crate::plant::gas::{GAS_CONSTANT, ROOM_K};
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};
use serde::{Deserialize, Serialize};

/// Parameters of the reservoir.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SupplyParameters {
    /// Pressure that the regulator holds, psi gauge (96.7 in the published excerpt of a log).
    pub pressure_psi: f64,
    /// Volume of the reservoir, mm³.
    pub volume_mm3: f64,
    /// Time constant with which the regulator restores the pressure, s.
    pub recovery_s: f64,
}

impl Default for SupplyParameters {
    fn default() -> Self {
        Self { pressure_psi: 96.7, volume_mm3: 4e5, recovery_s: 0.5 }
    }
}

/// The reservoir, at room temperature.
#[derive(Debug, Clone, Copy)]
pub struct Supply {
    parameters: SupplyParameters,
    pressure_kpa: f64,
}

impl Supply {
    /// A full reservoir.
    #[must_use]
    pub fn new(parameters: SupplyParameters) -> Self {
        Self { parameters, pressure_kpa: Self::set_kpa(&parameters) }
    }

    fn set_kpa(p: &SupplyParameters) -> f64 {
        p.pressure_psi * KPA_PER_PSI + ATMOSPHERE_KPA
    }

    /// Pressure, kPa absolute.
    #[must_use]
    pub fn pressure_kpa(&self) -> f64 {
        self.pressure_kpa
    }

    /// Releases `mass_g` of air, then refills for a time.
    pub fn give(&mut self, mass_g: f64, time_s: f64) {
        let p = &self.parameters;
        self.pressure_kpa -= mass_g * GAS_CONSTANT * ROOM_K / p.volume_mm3;
        let set = Self::set_kpa(p);
        self.pressure_kpa = set + (self.pressure_kpa - set) * (-time_s / p.recovery_s).exp();
    }
}
