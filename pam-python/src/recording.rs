//! Recordings.

use crate::arrays::view;
use crate::errors::{raised, settings};
use crate::watch::watched;
use numpy::{PyArray1, PyReadonlyArray1, PyUntypedArrayMethods};
use pam_core::{NamedChoice, SealedMasses};
use pam_data::recording::LowPassed;
use pam_data::{
    LoadOptions, PressureReference, RigFile, collect_paths_of, read_files, write_recording,
};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// One run of the joint. Columns are views of the recording's own memory, read-only.
#[pyclass(frozen, subclass, module = "pam_ode._pam")]
pub(crate) struct Recording {
    pub(crate) inner: Arc<pam_data::Recording>,
}

impl Recording {
    /// The recording as the class that users see.
    pub(crate) fn wrapped(
        py: Python<'_>,
        inner: Arc<pam_data::Recording>,
    ) -> PyResult<Bound<'_, PyAny>> {
        let native = Bound::new(py, Self { inner })?;
        py.import("pam_ode.recording")?.getattr("Recording")?.call_method1("_of", (native,))
    }
}

fn column(name: &str, array: &PyReadonlyArray1<'_, f64>, len: usize) -> PyResult<Vec<f64>> {
    if array.len() != len {
        return Err(settings(format!("`{name}` has {} samples, `time_s` has {len}", array.len())));
    }
    Ok(array.as_array().to_vec())
}

#[pymethods]
impl Recording {
    /// A recording from columns in the framework's units.
    #[new]
    #[pyo3(signature = (name, time_s, displacement_mm, velocity_mm_s, pressure_flexor_kpa, pressure_extensor_kpa, force_mn, masses_g, notes))]
    fn new(
        name: String,
        time_s: PyReadonlyArray1<'_, f64>,
        displacement_mm: PyReadonlyArray1<'_, f64>,
        velocity_mm_s: PyReadonlyArray1<'_, f64>,
        pressure_flexor_kpa: PyReadonlyArray1<'_, f64>,
        pressure_extensor_kpa: PyReadonlyArray1<'_, f64>,
        force_mn: PyReadonlyArray1<'_, f64>,
        masses_g: Option<[f64; 2]>,
        notes: Vec<String>,
    ) -> PyResult<Self> {
        let n = time_s.len();
        let given_masses =
            masses_g.map(|[f, e]| SealedMasses::new(f, e)).transpose().map_err(raised)?;
        let inner = pam_data::Recording {
            time_s: time_s.as_array().to_vec(),
            displacement_mm: column("displacement_mm", &displacement_mm, n)?,
            velocity_mm_s: column("velocity_mm_s", &velocity_mm_s, n)?,
            pressure_flexor_kpa: column("pressure_flexor_kpa", &pressure_flexor_kpa, n)?,
            pressure_extensor_kpa: column("pressure_extensor_kpa", &pressure_extensor_kpa, n)?,
            force_mn: column("force_n", &force_mn, n)?,
            given_masses,
            notes,
            low_passed: LowPassed::default(),
            preprocessing: "taken as given".into(),
            ..pam_data::Recording::empty(&name)
        };
        inner.validate().map_err(raised)?;
        Ok(Self { inner: Arc::new(pam_data::Recording { name, ..inner }) })
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    #[getter]
    fn source(&self) -> String {
        self.inner.source.display().to_string()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.inner.notes.clone()
    }

    #[getter]
    fn preprocessing(&self) -> &str {
        &self.inner.preprocessing
    }

    #[getter]
    fn masses_g(&self) -> Option<[f64; 2]> {
        self.inner.given_masses.map(|m| [m.flexor_g, m.extensor_g])
    }

    #[getter]
    fn command_psi(&self) -> Option<[f64; 2]> {
        self.inner.command_psi
    }

    /// A column by its name, with `force_mn` in mN.
    fn column<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let r = &slf.get().inner;
        let values = match name {
            "time_s" => &r.time_s,
            "displacement_mm" => &r.displacement_mm,
            "velocity_mm_s" => &r.velocity_mm_s,
            "pressure_flexor_kpa" => &r.pressure_flexor_kpa,
            "pressure_extensor_kpa" => &r.pressure_extensor_kpa,
            "force_mn" => &r.force_mn,
            _ => return Err(settings(format!("there is no column `{name}`"))),
        };
        Ok(view(slf.as_any(), values))
    }

    /// The samples `start..end` as a recording of its own.
    fn slice(&self, start: usize, end: usize) -> PyResult<Self> {
        if end > self.inner.len() || end < start + 2 {
            return Err(settings(format!(
                "samples {start} to {end} of {} are no recording; at least two are needed",
                self.inner.len()
            )));
        }
        Ok(Self { inner: Arc::new(self.inner.slice(start..end)) })
    }

    /// The same with another name.
    fn renamed(&self, name: String) -> Self {
        Self { inner: Arc::new(pam_data::Recording { name, ..(*self.inner).clone() }) }
    }

    /// Writes a `.csv` or `.npz` file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let inner = Arc::clone(&self.inner);
        watched(py, |_| write_recording(&path, &inner))?.map_err(raised)
    }
}

/// Reads the recordings of files and folders in parallel.
#[pyfunction]
#[pyo3(signature = (paths, *, pressure, preprocess, loader, rig_file, progress))]
pub(crate) fn read(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    pressure: &str,
    preprocess: bool,
    loader: Vec<String>,
    rig_file: Option<PathBuf>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<Recording>> {
    let rig = rig_file.map(RigFile::read).transpose().map_err(raised)?;
    let mut options = LoadOptions {
        rig,
        preprocess,
        pressure_reference: PressureReference::from_name(pressure).map_err(raised)?,
        ..LoadOptions::default()
    };
    for assignment in &loader {
        let set = options.raw_log.set(assignment);
        set.map_err(|e| settings(format!("loader: {assignment}: {e}")))?;
    }
    let read = watched(py, |stop| {
        let paths = collect_paths_of(&paths, options.rig.as_ref())?;
        stop.call(progress.as_ref(), ("reading", 0.0, ""));
        let total = paths.len() as f64;
        let done = std::sync::atomic::AtomicUsize::new(0);
        read_files(&paths, &options, &|| {
            stop.check();
            let k = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
            stop.call(progress.as_ref(), ("reading", k as f64 / total, ""));
        })
    })?;
    let wrap = |r| Recording { inner: Arc::new(r) };
    Ok(read.map_err(raised)?.into_iter().map(wrap).collect())
}
