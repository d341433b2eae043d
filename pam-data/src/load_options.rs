//! How recordings are read.

use crate::preprocess::RawLogOptions;
use crate::rig_file::RigFile;
use pam_core::NamedChoice;
use pam_core::units::ATMOSPHERE_KPA;

/// How recordings are read.
///
/// ```
/// use pam_data::{LoadOptions, PressureReference, read_recordings};
///
/// let path = std::env::temp_dir().join(format!("pam-load-options-{}.csv", std::process::id()));
/// std::fs::write(&path, "time_s,displacement_mm,pressure_flexor_kpa,pressure_extensor_kpa,force_n\n0,0,310,310,0\n0.001,0,310,310,0\n0.002,0,310,310,0\n")?;
/// let options = LoadOptions { pressure_reference: PressureReference::Gauge, ..LoadOptions::default() };
/// let recordings = read_recordings([&path], &options)?;
/// assert!((recordings[0].pressure_flexor_kpa[0] - 411.325).abs() < 1e-9); // kPa absolute
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LoadOptions {
    /// Constants of the raw-log loader; its cutoff also serves `preprocess`.
    pub raw_log: RawLogOptions,
    /// Filter data that are no raw log like a raw log and take the velocity anew. Without it they are
    /// taken as they are.
    pub preprocess: bool,
    /// The zero of the pressures of CSV, `.npz` and `.mat` data; raw logs are gauge by definition.
    pub pressure_reference: PressureReference,
    /// The rig whose files these are; [`None`] for files with the columns of their format.
    pub rig: Option<RigFile>,
    /// Keep the external force as it is after its filter only. The force before the filter, a seventh of the numbers of a recording,
    /// serves diagnoses and models with effects.
    pub filtered_force_only: bool,
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

impl LoadOptions {
    /// The atmosphere: that of the rig file, else the standard one; kPa.
    #[must_use]
    pub fn atmosphere_kpa(&self) -> f64 {
        self.rig.as_ref().map_or(ATMOSPHERE_KPA, |rig| rig.air.atmosphere_kpa)
    }

    /// The zero of pressures that are absolute unless [`pressure_reference`](Self::pressure_reference) says otherwise, kPa.
    pub(crate) fn zero_kpa(&self) -> f64 {
        if self.pressure_reference == PressureReference::Gauge {
            self.atmosphere_kpa()
        } else {
            0.0
        }
    }

    /// The first constant of the raw-log loader that was changed and that no other file uses; `--preprocess` uses the
    /// cutoff.
    pub(crate) fn unused_raw_log_option(&self) -> Option<String> {
        let all = |options: &RawLogOptions| match serde_json::to_value(options) {
            Ok(serde_json::Value::Object(fields)) => fields,
            _ => serde_json::Map::new(),
        };
        let published = all(&RawLogOptions::default());
        let used = |key: &str| self.preprocess && key == "cutoff_hz";
        all(&self.raw_log)
            .into_iter()
            .find(|(key, value)| published.get(key) != Some(value) && !used(key))
            .map(|(key, _)| key)
    }

    /// The same with the constants of the raw-log loader that the rig file gives: pulley, motor, atmosphere, filter.
    #[must_use]
    pub(crate) fn of_rig(&self) -> Self {
        let mut options = self.clone();
        if let Some(rig) = &self.rig {
            let published = RawLogOptions::default();
            let log = &mut options.raw_log;
            // An option that was changed by its own name wins.
            let set = |value: &mut f64, given: Option<f64>, published: f64| {
                if let Some(given) = given.filter(|_| *value == published) {
                    *value = given;
                }
            };
            let torque = rig.drive.torque_constant_nm_per_a.map(|c| 1e3 * c);
            set(&mut log.pulley_radius_mm, rig.drive.pulley_radius_mm, published.pulley_radius_mm);
            set(&mut log.torque_constant_mnm_per_a, torque, published.torque_constant_mnm_per_a);
            set(&mut log.gear_ratio, rig.drive.gear_ratio, published.gear_ratio);
            set(&mut log.atmosphere_kpa, Some(rig.air.atmosphere_kpa), published.atmosphere_kpa);
            set(&mut log.cutoff_hz, rig.filter.displacement_hz, published.cutoff_hz);
        }
        options
    }
}
