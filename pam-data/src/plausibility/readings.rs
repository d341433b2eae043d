//! Which units, references and signs the columns of pressure and displacement may really have.

use super::gas::PressureReading;
use super::settings::PlausibilitySettings;
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI, PULLEY_RADIUS_MM};

/// A unit of pressure and its size in kPa.
const PRESSURE_UNITS: [(&str, f64); 6] = [
    ("kPa", 1.0),
    ("Pa", 1e-3),
    ("hPa (mbar)", 0.1),
    ("bar", 100.0),
    ("MPa", 1e3),
    ("psi", KPA_PER_PSI),
];

/// A unit of displacement and its size in mm; angles turn the pulley.
pub(super) const DISPLACEMENT_UNITS: [(&str, f64); 7] = [
    ("mm", 1.0),
    ("m", 1e3),
    ("cm", 10.0),
    ("µm", 1e-3),
    ("inches", 25.4),
    ("degrees of the pulley", PULLEY_RADIUS_MM * std::f64::consts::PI / 180.0),
    ("radians of the pulley", PULLEY_RADIUS_MM),
];

/// A candidate for the pressure columns.
#[derive(Debug, Clone, Copy)]
pub(super) struct PressureUnit {
    /// Name of the unit.
    pub(super) unit: &'static str,
    /// `true` if the values count from the atmosphere.
    pub(super) gauge: bool,
    /// `true` if the values were read as a raw log's psi gauge on top.
    pub(super) raw_log: bool,
    /// The conversion to absolute kPa.
    pub(super) reading: PressureReading,
    /// Log odds before the data are seen.
    pub(super) prior: f64,
}

impl PressureUnit {
    /// `true` if only the atmosphere is missing.
    pub(super) fn is_gauge_kpa(&self) -> bool {
        self.gauge && self.unit == "kPa" && !self.raw_log
    }
}

/// All candidates, the stated one first. `from_log` says that the recording is named like a raw log.
pub(super) fn pressure_units(from_log: bool, s: &PlausibilitySettings) -> Vec<PressureUnit> {
    let mut all = Vec::new();
    for raw_log in [false, true] {
        for (unit, size) in PRESSURE_UNITS {
            for gauge in [false, true] {
                let reference = if gauge { ATMOSPHERE_KPA } else { 0.0 };
                // A raw log's value is (P − atmosphere)/psi of the recording's pressure P.
                let (scale, offset_kpa) = if raw_log {
                    (size / KPA_PER_PSI, reference - size / KPA_PER_PSI * ATMOSPHERE_KPA)
                } else {
                    (size, reference)
                };
                let reading = PressureReading { scale, offset_kpa };
                let stated = if raw_log {
                    unit == "psi" && gauge
                } else {
                    reading == PressureReading::STATED
                };
                if raw_log && stated {
                    continue;
                }
                let unlikely_origin = if raw_log == from_log { 0.0 } else { -3.0 };
                let prior = match (stated, unit == "kPa" && gauge && !raw_log) {
                    (true, _) => 0.0,
                    (_, true) => s.gauge_prior,
                    _ => s.unit_prior + unlikely_origin,
                };
                all.push(PressureUnit { unit, gauge, raw_log, reading, prior });
            }
        }
    }
    all
}
