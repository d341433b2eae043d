//! How recordings are read.

use crate::preprocess::RawLogOptions;
use pam_core::NamedChoice;

/// How recordings are read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LoadOptions {
    /// Constants of the raw-log loader; its cutoff also serves `preprocess`.
    pub raw_log: RawLogOptions,
    /// Filter data that are no raw log like a raw log and take the velocity anew. Without it they are
    /// taken as they are.
    pub preprocess: bool,
    /// The zero of a `.mat` run's pressures.
    pub pressure_reference: PressureReference,
}

/// The zero of a pressure column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PressureReference {
    /// Decide by the gas law.
    #[default]
    Auto,
    /// Zero is vacuum.
    Absolute,
    /// Zero is the atmosphere.
    Gauge,
}

impl NamedChoice for PressureReference {
    const KIND: &'static str = "pressure reference";
    const ALL: &'static [(&'static str, Self, &'static str)] = &[
        ("auto", Self::Auto, "decide by the gas law and print the decision"),
        ("absolute", Self::Absolute, "zero is vacuum"),
        ("gauge", Self::Gauge, "zero is the atmosphere"),
    ];
}
