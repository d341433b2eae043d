//! Air in a chamber: mass, temperature, heat exchange with the wall.

use serde::{Deserialize, Serialize};

/// Temperature of room, wall and supply, K (Wang and Realmuto 2026, table I).
pub const ROOM_K: f64 = 295.15;
/// Specific gas constant of air, kPa·mm³/(g·K): C / T with C = 8.47e7 kPa·mm³/g at room temperature.
pub const GAS_CONSTANT: f64 = pam_core::units::GAS_COEFFICIENT_KPA_MM3_PER_G / ROOM_K;
/// Ratio of specific heats of air.
pub const HEAT_RATIO: f64 = 1.4;
/// Specific heat at constant volume, kPa·mm³/(g·K) (1 kPa·mm³ = 1 µJ).
pub const HEAT_CAPACITY_V: f64 = GAS_CONSTANT / (HEAT_RATIO - 1.0);
/// Specific heat at constant pressure, kPa·mm³/(g·K).
pub const HEAT_CAPACITY_P: f64 = HEAT_RATIO * HEAT_CAPACITY_V;
/// Thermal conductivity of air, kPa·mm³/(s·mm·K) (0.026 W/(m·K)).
const CONDUCTIVITY: f64 = 26.0;
/// Squared zeros of the Bessel function J₀ for the radial modes of conduction in a cylinder.
const MODES: [f64; 3] = [5.783_186, 30.471_262, 74.887_007];
/// Shares 4/β² of the modes in the mean temperature; the last one stands for all that follow.
const SHARES: [f64; 3] = [4.0 / MODES[0], 4.0 / MODES[1], 1.0 - 4.0 / MODES[0] - 4.0 / MODES[1]];

/// How the air exchanges heat with the wall.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum HeatExchange {
    /// Always at room temperature.
    Isothermal,
    /// No exchange.
    Adiabatic,
    /// Conduction through the air to a wall at room temperature, `scale` times as good as in a still
    /// cylinder of the bore's radius.
    Conduction {
        /// Factor of the conductivity; 1 is still air.
        scale: f64,
    },
}

/// The factor is calibrated, see `docs/rig.md`.
impl Default for HeatExchange {
    fn default() -> Self {
        Self::Conduction { scale: 0.55 }
    }
}

/// Work, heat and enthalpy that crossed the border of a chamber, µJ (kPa·mm³).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GasLedger {
    /// Work done by the air, ∫ P dV.
    pub work_uj: f64,
    /// Heat given to the wall.
    pub heat_uj: f64,
    /// Enthalpy that flowed in with air, less what flowed out.
    pub enthalpy_uj: f64,
}

/// The air of one chamber.
///
/// The temperature is `T = T_room + Σ w_k θ_k`: compression heats all modes alike (the state of a
/// well-mixed gas), then mode k relaxes to the wall with the time constant of radial conduction
///
/// ```text
/// τ_k = r² ρ c_p / (β_k² k_air)      (0.8 s for the slowest at 412 kPa)
/// ```
///
/// (Carslaw and Jaeger 1959, section 7.6). Slow motion is isothermal, fast motion adiabatic, and
/// between them the pressure runs ahead of the isothermal one. With U = m c_v T the balance
/// `ΔU = −W − Q + H` closes to rounding in every step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chamber {
    /// Mass of air, g.
    pub mass_g: f64,
    /// Temperature of each mode above the room, K.
    modes_k: [f64; 3],
    volume_mm3: f64,
    exchange: HeatExchange,
    radius_mm: f64,
    /// Sums of work, heat and enthalpy so far.
    pub ledger: GasLedger,
}

impl Chamber {
    /// Air at room temperature and `pressure_kpa` (absolute) in a volume.
    #[must_use]
    pub fn at_rest(
        pressure_kpa: f64,
        volume_mm3: f64,
        radius_mm: f64,
        exchange: HeatExchange,
    ) -> Self {
        Self {
            mass_g: pressure_kpa * volume_mm3 / (GAS_CONSTANT * ROOM_K),
            modes_k: [0.0; 3],
            volume_mm3,
            exchange,
            radius_mm,
            ledger: GasLedger::default(),
        }
    }

    /// Fills the chamber to a pressure (kPa absolute) at room temperature; the ledger starts anew.
    pub fn refill(&mut self, pressure_kpa: f64) {
        *self = Self::at_rest(pressure_kpa, self.volume_mm3, self.radius_mm, self.exchange);
    }

    /// Mean temperature, K.
    #[must_use]
    pub fn temperature_k(&self) -> f64 {
        let [a, b, c] = self.modes_k;
        ROOM_K + SHARES[0] * a + SHARES[1] * b + SHARES[2] * c
    }

    /// Pressure, kPa absolute.
    #[must_use]
    pub fn pressure_kpa(&self) -> f64 {
        self.mass_g * GAS_CONSTANT * self.temperature_k() / self.volume_mm3
    }

    /// Volume, mm³.
    #[must_use]
    pub fn volume_mm3(&self) -> f64 {
        self.volume_mm3
    }

    /// Internal energy, µJ.
    #[must_use]
    pub fn energy_uj(&self) -> f64 {
        self.mass_g * HEAT_CAPACITY_V * self.temperature_k()
    }

    /// Availability of the air against the room, µJ: U − U₀ + P₀ (V − V₀) − T₀ (S − S₀), relative to
    /// the same mass in the room. It falls in everything a closed chamber does but being compressed.
    /// The entropy is that of the mean temperature less that of the modes' spread, to second order:
    /// air whose modes differ can let heat flow out while it is cold in the mean.
    #[must_use]
    pub fn availability_uj(&self) -> f64 {
        let room_kpa = pam_core::units::ATMOSPHERE_KPA;
        let room_mm3 = self.mass_g * GAS_CONSTANT * ROOM_K / room_kpa;
        let temperature = self.temperature_k();
        let entropy = self.mass_g
            * (HEAT_CAPACITY_V * (temperature / ROOM_K).ln()
                + GAS_CONSTANT * (self.volume_mm3 / room_mm3).ln());
        let [a, b, c] = self.modes_k.map(|theta| (ROOM_K + theta - temperature).powi(2));
        let spread = SHARES[0] * a + SHARES[1] * b + SHARES[2] * c;
        let unevenness = 0.5 * self.mass_g * HEAT_CAPACITY_V * spread / ROOM_K;
        unevenness
            + self.mass_g * HEAT_CAPACITY_V * (temperature - ROOM_K)
            + room_kpa * (self.volume_mm3 - room_mm3)
            - ROOM_K * entropy
    }

    /// Changes the volume fast: adiabatic, `T V^(γ−1)` constant (isothermal air gives its work as
    /// heat at once).
    pub fn compress(&mut self, volume_mm3: f64) {
        if volume_mm3 == self.volume_mm3 {
            return;
        }
        let before = self.temperature_k();
        let ratio = self.volume_mm3 / volume_mm3;
        self.volume_mm3 = volume_mm3;
        if self.exchange == HeatExchange::Isothermal {
            let work = -self.mass_g * GAS_CONSTANT * before * ratio.ln();
            self.ledger.work_uj += work;
            self.ledger.heat_uj -= work;
            return;
        }
        let rise = before * ((HEAT_RATIO - 1.0) * ratio.ln()).exp_m1();
        self.heat_all(rise);
        self.ledger.work_uj -= self.mass_g * HEAT_CAPACITY_V * rise;
    }

    /// Exchanges heat with the wall for a time; exact for the modes at this density.
    pub fn relax(&mut self, time_s: f64) {
        let HeatExchange::Conduction { scale } = self.exchange else { return };
        let per_mass = self.radius_mm * self.radius_mm * HEAT_CAPACITY_P
            / (self.volume_mm3 * CONDUCTIVITY * scale);
        let before = self.temperature_k();
        for (theta, squared_zero) in self.modes_k.iter_mut().zip(MODES) {
            *theta *= (-time_s * squared_zero / (per_mass * self.mass_g)).exp();
        }
        let fall = before - self.temperature_k();
        self.ledger.heat_uj += self.mass_g * HEAT_CAPACITY_V * fall;
    }

    /// Lets air in (positive, at `inflow_k`) or out (negative, at the chamber's own temperature).
    pub fn exchange_air(&mut self, mass_g: f64, inflow_k: f64) {
        if mass_g == 0.0 {
            return;
        }
        let temperature = self.temperature_k();
        let carried = if mass_g > 0.0 { inflow_k } else { temperature };
        let enthalpy = mass_g * HEAT_CAPACITY_P * carried;
        let energy = self.energy_uj() + enthalpy;
        self.mass_g += mass_g;
        self.ledger.enthalpy_uj += enthalpy;
        if self.exchange == HeatExchange::Isothermal {
            self.ledger.heat_uj += energy - self.energy_uj();
        } else {
            self.heat_all(energy / (self.mass_g * HEAT_CAPACITY_V) - temperature);
        }
    }

    fn heat_all(&mut self, rise_k: f64) {
        for theta in &mut self.modes_k {
            *theta += rise_k;
        }
    }
}
