//! Origin of a recording: readings, filters, commands.

use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};

/// The joint at rest after its valves were closed, before the excitation began.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SealedReading {
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Flexor pressure, kPa absolute.
    pub pressure_flexor_kpa: f64,
    /// Extensor pressure, kPa absolute.
    pub pressure_extensor_kpa: f64,
}

/// How the pressures of a file are stated, where that is not kPa absolute.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedPressure {
    /// Name of the unit.
    pub unit: &'static str,
    /// One of it, kPa.
    pub kpa: f64,
    /// True if zero is the atmosphere.
    pub gauge: bool,
}

impl StatedPressure {
    /// psi gauge, as raw logs have it.
    pub const RAW_LOG: Self = Self { unit: "psi", kpa: KPA_PER_PSI, gauge: true };

    /// True for the unit of raw logs.
    #[must_use]
    pub fn raw_log(&self) -> bool {
        *self == Self::RAW_LOG
    }

    /// Unit and zero in words.
    #[must_use]
    pub fn describe(&self) -> String {
        format!("{} {}", self.unit, if self.gauge { "gauge" } else { "absolute" })
    }

    /// The pressure at the file's zero, kPa absolute.
    #[must_use]
    pub fn offset_kpa(&self) -> f64 {
        if self.gauge { ATMOSPHERE_KPA } else { 0.0 }
    }
}

/// The zero-phase low-pass behind a recording's columns: what a simulation must go through before it is
/// compared with them. A filter and a nonlinear joint do not commute, so the joint is simulated with the
/// force before the filter, and its outputs are filtered as the data were.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LowPassed {
    /// Cutoffs of x, ẋ, P_f, P_e, Hz; `None` where nothing was filtered.
    pub cutoff_hz: [Option<f64>; 4],
    /// The force before its filter, mN, if that is known and differs from the recorded one.
    pub force_mn: Option<Vec<f64>>,
    /// Steps of the sensors of x, ẋ, P_f, P_e, in the units of the channels, which the filters have blurred; 0 where they are
    /// not known.
    pub resolution: [f64; 4],
}
