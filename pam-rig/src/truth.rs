//! The ground truth of a recording, which no estimator may read.

use crate::plant::Plant;
use pam_data::DataError;
use pam_data::formats::npz::{self, Array};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The truth at one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruthRow {
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Velocity, mm/s.
    pub velocity_mm_s: f64,
    /// Absolute pressures of flexor and extensor, kPa.
    pub pressures_kpa: [f64; 2],
    /// Air in flexor and extensor, g (dead volume included).
    pub masses_g: [f64; 2],
    /// Temperatures of the air, K.
    pub temperatures_k: [f64; 2],
    /// Volumes of the air, mm³.
    pub volumes_mm3: [f64; 2],
    /// Tensions of the tendons, N.
    pub tensions_n: [f64; 2],
    /// Force of the motor along +x until the next sample, N.
    pub force_n: f64,
    /// Dry friction along +x until the next sample, N.
    pub friction_n: f64,
}

impl TruthRow {
    /// The state of the plant; force and friction are zero until they are known.
    #[must_use]
    pub fn of(plant: &Plant) -> Self {
        let each =
            |f: fn(&crate::plant::Chamber) -> f64| [0, 1].map(|i| f(&plant.muscles()[i].air));
        Self {
            displacement_mm: plant.displacement_mm(),
            velocity_mm_s: plant.velocity_mm_s(),
            pressures_kpa: plant.pressures_kpa(),
            masses_g: each(|air| air.mass_g),
            temperatures_k: each(crate::plant::Chamber::temperature_k),
            volumes_mm3: each(crate::plant::Chamber::volume_mm3),
            tensions_n: plant.tensions_n(),
            force_n: 0.0,
            friction_n: 0.0,
        }
    }
}

/// The ground truth of a recording, one row per frame of its log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Truth {
    /// True time of the first frame, s; the excitation begins at zero.
    pub start_s: f64,
    /// True time between frames, s.
    pub sample_s: f64,
    /// The rows.
    pub rows: Vec<TruthRow>,
}

impl Truth {
    /// The file of the truth that belongs to a log.
    #[must_use]
    pub fn path_for(log: impl AsRef<Path>) -> PathBuf {
        let log = log.as_ref();
        let name = log.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        log.with_file_name(format!("{name}{}", pam_data::TRUTH_SUFFIX))
    }

    /// The arrays of the file, all named `truth_…`, one value per frame.
    #[must_use]
    pub fn to_arrays(&self) -> BTreeMap<String, Array> {
        type Column = (&'static str, fn(&TruthRow) -> f64);
        const COLUMNS: [Column; 14] = [
            ("displacement_mm", |r| r.displacement_mm),
            ("velocity_mm_s", |r| r.velocity_mm_s),
            ("pressure_flexor_kpa", |r| r.pressures_kpa[0]),
            ("pressure_extensor_kpa", |r| r.pressures_kpa[1]),
            ("mass_flexor_g", |r| r.masses_g[0]),
            ("mass_extensor_g", |r| r.masses_g[1]),
            ("temperature_flexor_k", |r| r.temperatures_k[0]),
            ("temperature_extensor_k", |r| r.temperatures_k[1]),
            ("volume_flexor_mm3", |r| r.volumes_mm3[0]),
            ("volume_extensor_mm3", |r| r.volumes_mm3[1]),
            ("tension_flexor_n", |r| r.tensions_n[0]),
            ("tension_extensor_n", |r| r.tensions_n[1]),
            ("force_n", |r| r.force_n),
            ("friction_n", |r| r.friction_n),
        ];
        let mut arrays: BTreeMap<String, Array> = COLUMNS
            .iter()
            .map(|(name, f)| {
                (format!("truth_{name}"), Array::vector(self.rows.iter().map(f).collect()))
            })
            .collect();
        arrays.insert("truth_start_s".into(), Array::scalar(self.start_s));
        arrays.insert("truth_sample_s".into(), Array::scalar(self.sample_s));
        arrays
    }

    /// Writes the file.
    ///
    /// # Errors
    /// [`DataError::Io`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), DataError> {
        self.write_at(path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn write_at(&self, path: &Path) -> Result<(), DataError> {
        npz::write(path, &self.to_arrays())
    }
}
