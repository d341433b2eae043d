//! Comparisons with baselines.

use crate::errors::{raised, settings};
use crate::recording::Recording;
use crate::watch::watched;
use pam_baselines::comparison::{ComparisonConfig, Event, split};
use pam_cli::options::built_in_spring_damper;
use pam_data::{MassOptions, MuscleSurfaces, Subject};
use pyo3::prelude::*;
use std::path::Path;
use std::sync::atomic::Ordering;

/// The result of a comparison.
#[pyclass(frozen, module = "pam_ode._pam")]
pub(crate) struct Comparison {
    comparison: pam_baselines::Comparison,
}

/// Fits the models of a configuration (TOML text) and scores them on recordings. The configuration's own recordings are not
/// read.
#[pyfunction]
#[pyo3(signature = (config, recordings, *, seed, progress))]
pub(crate) fn compare(
    py: Python<'_>,
    config: &str,
    recordings: Vec<PyRef<'_, Recording>>,
    seed: u64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Comparison> {
    let config = ComparisonConfig::parse(config, Path::new("comparison")).map_err(raised)?;
    let surfaces = config.data.surfaces.as_deref().map(MuscleSurfaces::read);
    let surfaces = surfaces.transpose().map_err(raised)?;
    let model = built_in_spring_damper(None);
    let recordings = recordings.iter().map(|r| (*r.inner).clone()).collect();
    let subjects = Subject::resolve(recordings, &model, &MassOptions::default()).map_err(raised)?;
    let sets = split(&config, subjects).map_err(raised)?;
    let comparison = watched(py, |stop| {
        let event = |event: Event<'_>| {
            let (text, share) = match event {
                Event::Fitting(name, share) => (format!("fitting {name}"), share),
                Event::Predicting(name, share) => (format!("predicting, {name}"), share),
                Event::Done(_) | Event::Kept(_) => return !stop.flag().load(Ordering::Relaxed),
            };
            stop.call(progress.as_ref(), ("comparing", share, text));
            !stop.flag().load(Ordering::Relaxed)
        };
        pam_baselines::compare(&config, &sets, surfaces.as_ref(), seed, None, &event)
    })?
    .map_err(raised)?;
    Ok(Comparison { comparison })
}

/// A configuration with every kind of model and its default settings, as TOML text.
#[pymethods]
impl Comparison {
    /// A configuration with every kind of model and its default settings, as TOML text.
    #[staticmethod]
    fn example() -> String {
        ComparisonConfig::example()
    }

    /// TOML text of a table given as JSON.
    #[staticmethod]
    fn toml(json: &str) -> PyResult<String> {
        let value: serde_json::Value =
            serde_json::from_str(json).map_err(|e| settings(e.to_string()))?;
        pam_data::document::to_toml(&value).map_err(|e| settings(e.to_string()))
    }

    /// Scores as JSON, as in `comparison.json`.
    fn json(&self) -> String {
        self.comparison.to_json().to_string()
    }

    /// Times as JSON.
    fn times(&self) -> String {
        self.comparison.times_json().to_string()
    }

    /// The table as CSV.
    fn csv(&self) -> String {
        self.comparison.to_csv()
    }

    /// The table in LaTeX.
    fn latex(&self) -> String {
        self.comparison.to_latex()
    }

    /// The page `report.html`.
    fn report(&self) -> String {
        self.comparison.report(&pam_cli::run_record::made_by())
    }
}
