//! How recordings are read.

use crate::preprocess::RawLogOptions;
use pam_core::NamedChoice;
use pam_core::units::ATMOSPHERE_KPA;

/// How recordings are read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LoadOptions {
    /// Constants of the raw-log loader; its cutoff also serves `preprocess`.
    pub raw_log: RawLogOptions,
    /// Filter data that are no raw log like a raw log and take the velocity anew. Without it they are
    /// taken as they are.
    pub preprocess: bool,
    /// The zero of the pressures of CSV, `.npz` and `.mat` data; raw logs are gauge by definition.
    pub pressure_reference: PressureReference,
}

/// The zero of a pressure column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PressureReference {
    /// As the columns' format states it: absolute in CSV and `.npz`, decided by the gas law in `.mat`.
    #[default]
    Auto,
    /// Zero is vacuum.
    Absolute,
    /// Zero is the atmosphere.
    Gauge,
}

impl PressureReference {
    /// What must be added to pressures that are absolute unless this says otherwise, kPa.
    #[must_use]
    pub fn offset_kpa(self) -> f64 {
        if self == Self::Gauge { ATMOSPHERE_KPA } else { 0.0 }
    }
}

impl NamedChoice for PressureReference {
    const KIND: &'static str = "pressure reference";
    const ALL: &'static [(&'static str, Self, &'static str)] = &[
        (
            "auto",
            Self::Auto,
            "absolute in CSV and .npz; in .mat decided by the gas law and printed",
        ),
        ("absolute", Self::Absolute, "zero is vacuum"),
        ("gauge", Self::Gauge, "zero is the atmosphere"),
    ];
}
