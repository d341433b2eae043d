//! Flow through the valves (ISO 6358-1:2013).

use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};
use serde::{Deserialize, Serialize};

/// Density of air at the reference atmosphere (100 kPa, 20 °C), g/dm³.
const REFERENCE_DENSITY_G_DM3: f64 = 1.185;

/// Model of valves and supply that the controller uses. Temperatures are those of the reference
/// atmosphere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ValveModel {
    /// Sonic conductance from the supply into a muscle, dm³/(s·bar).
    pub inflate_conductance: f64,
    /// Sonic conductance out of a muscle, dm³/(s·bar).
    pub exhaust_conductance: f64,
    /// Critical pressure ratio b.
    pub critical_ratio: f64,
    /// Pressure of the supply, kPa absolute.
    pub supply_kpa: f64,
    /// Shortest time that a valve is open, s.
    pub shortest_s: f64,
}

impl Default for ValveModel {
    fn default() -> Self {
        Self {
            inflate_conductance: 0.020,
            exhaust_conductance: 0.020,
            critical_ratio: 0.3,
            supply_kpa: 96.7 * KPA_PER_PSI + ATMOSPHERE_KPA,
            shortest_s: 3e-3,
        }
    }
}

impl ValveModel {
    /// Flow into a muscle at a pressure (kPa absolute) while its inflation valve is open, g/s.
    #[must_use]
    pub fn inflow_g_s(&self, pressure_kpa: f64) -> f64 {
        self.flow(self.inflate_conductance, self.supply_kpa, pressure_kpa)
    }

    /// Flow out of a muscle while its exhaust valve is open, g/s.
    #[must_use]
    pub fn outflow_g_s(&self, pressure_kpa: f64) -> f64 {
        self.flow(self.exhaust_conductance, pressure_kpa, ATMOSPHERE_KPA)
    }

    fn flow(&self, conductance: f64, upstream_kpa: f64, downstream_kpa: f64) -> f64 {
        let ratio = downstream_kpa / upstream_kpa;
        if ratio >= 1.0 {
            return 0.0;
        }
        let place = ((ratio - self.critical_ratio) / (1.0 - self.critical_ratio)).max(0.0);
        conductance * REFERENCE_DENSITY_G_DM3 * 1e-2 * upstream_kpa * (1.0 - place * place).sqrt()
    }
}
