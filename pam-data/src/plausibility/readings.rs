//! Which units, references and signs the columns of pressure and displacement may really have.

use super::gas::PressureReading;
use super::settings::PlausibilitySettings;
use crate::recording::{Recording, StatedPressure};
use crate::rig_file::units::{self, Quantity};
use pam_core::units::ATMOSPHERE_KPA;
use std::sync::LazyLock;

/// Names of the units of displacement that are looked for, and their sizes in mm, the stated one first.
pub(super) static DISPLACEMENT_UNITS: LazyLock<Vec<(&'static str, f64)>> =
    LazyLock::new(|| units::mistaken(Quantity::Displacement));

/// A candidate for the pressure columns.
#[derive(Debug, Clone, Copy)]
pub(super) struct PressureUnit {
    /// Name of the unit.
    pub(super) unit: &'static str,
    /// `true` if the values count from the atmosphere.
    pub(super) gauge: bool,
    /// The unit in which the values stand in their file, if that is not kPa absolute: this reading replaces it.
    pub(super) in_file: Option<StatedPressure>,
    /// The conversion to absolute kPa.
    pub(super) reading: PressureReading,
    /// Log odds before the data are seen.
    pub(super) prior: f64,
}

impl PressureUnit {
    /// `true` if only the atmosphere is missing.
    pub(super) fn is_gauge_kpa(&self) -> bool {
        let other_zero = |file: StatedPressure| !file.gauge && file.unit == self.unit;
        self.gauge && self.in_file.map_or(self.unit == "kPa", other_zero)
    }
}

/// The unit of pressures in the files of most of these recordings: that of their rig file, or psi gauge if they are named
/// like raw logs.
pub(super) fn unit_in_file<'r>(
    recordings: impl Iterator<Item = &'r Recording> + Clone,
) -> Option<StatedPressure> {
    let count = recordings.clone().count();
    let stated = recordings.clone().find_map(|r| r.pressure_in_file);
    let named = recordings.filter(|r| r.command_psi.is_some()).count();
    stated.or((2 * named > count).then_some(StatedPressure::RAW_LOG))
}

/// All candidates, the stated one first. `from` is the unit of the files, if it is known.
pub(super) fn pressure_units(
    from: Option<StatedPressure>,
    s: &PlausibilitySettings,
) -> Vec<PressureUnit> {
    let sizes = units::mistaken(Quantity::Pressure);
    let mut all = Vec::new();
    for in_file in [None, Some(from.unwrap_or(StatedPressure::RAW_LOG))] {
        for &(unit, size) in &sizes {
            for gauge in [false, true] {
                let reference = if gauge { ATMOSPHERE_KPA } else { 0.0 };
                // The value in a file of gauge pressures is (P − atmosphere)/unit of the recording's pressure P.
                let (scale, offset_kpa) = match in_file {
                    Some(file) => {
                        (size / file.kpa, reference - size / file.kpa * file.offset_kpa())
                    }
                    None => (size, reference),
                };
                let reading = PressureReading { scale, offset_kpa };
                let same_unit =
                    in_file.map_or(size == 1.0, |file| (size / file.kpa - 1.0).abs() < 1e-3);
                let stated = match in_file {
                    Some(file) => same_unit && gauge == file.gauge,
                    None => reading == PressureReading::STATED,
                };
                if in_file.is_some() && stated {
                    continue;
                }
                let unlikely_origin = if in_file.is_some() == from.is_some() { 0.0 } else { -3.0 };
                // Gauge for absolute pressures in the right unit, or the reverse, is the most frequent mistake.
                let other_zero = match in_file {
                    Some(file) => {
                        from.is_some_and(|f| !f.raw_log()) && same_unit && gauge != file.gauge
                    }
                    None => unit == "kPa" && gauge && from.is_none_or(|f| f.raw_log()),
                };
                let prior = match (stated, other_zero) {
                    (true, _) => 0.0,
                    (_, true) => s.gauge_prior,
                    _ => s.unit_prior + unlikely_origin,
                };
                all.push(PressureUnit { unit, gauge, in_file, reading, prior });
            }
        }
    }
    all
}
