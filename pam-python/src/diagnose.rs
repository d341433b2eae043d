//! Diagnoses.

use crate::arrays::rows;
use crate::errors::{raised, settings};
use crate::model::Model;
use crate::options::mass_options;
use crate::recording::Recording;
use crate::watch::watched;
use numpy::{PyArray1, PyArray2};
use pam_cli::options::describe_model;
use pam_diagnose::joint::EffectLadder;
use pam_diagnose::report::{ReportContext, diagnosis_report, verdict_sentence};
use pam_diagnose::{DiagnoseOptions, DiagnosisSettings, JointDiagnosis, RecordingSets, Stage};
use pam_effects::EffectRecord;
use pam_effects::effects::{AnyEffect, by_id};
use pyo3::prelude::*;
use std::path::PathBuf;

/// The result of a diagnosis.
#[pyclass(frozen, module = "pam_ode._pam")]
pub(crate) struct Diagnosis {
    diagnosis: JointDiagnosis,
    context: ReportContext,
    provenance: String,
}

/// The effects with these ids.
fn with_ids(ids: &[String]) -> PyResult<Vec<&'static dyn AnyEffect>> {
    let of = |id: &String| by_id(id).ok_or_else(|| raised(EffectRecord::unknown(id, &[])));
    ids.iter().map(of).collect()
}

/// The ladder of a name or of a file of effects, or with the effects of these ids.
fn ladder_of(name: String, ids: &[String]) -> PyResult<EffectLadder> {
    if !ids.is_empty() {
        return Ok(EffectLadder { name, effects: with_ids(ids)? });
    }
    let known = EffectLadder::named(&name).ok_or_else(|| {
        settings(format!(
            "ladder: there is no ladder `{name}`; there is friction, or give a file of effects or their ids"
        ))
    })?;
    known.map_err(raised)
}

/// Diagnoses recordings with a model.
#[pyfunction]
#[pyo3(signature = (model, data, test, baseline, *, effects, changes, noise, accept, ladder, law, seed, masses, surfaces, progress))]
pub(crate) fn diagnose(
    py: Python<'_>,
    model: &Model,
    data: Vec<PyRef<'_, Recording>>,
    test: Option<Vec<PyRef<'_, Recording>>>,
    baseline: Option<Vec<PyRef<'_, Recording>>>,
    effects: Option<Vec<String>>,
    changes: Vec<String>,
    noise: [Option<f64>; 3],
    accept: bool,
    ladder: Option<(String, Vec<String>)>,
    law: bool,
    seed: u64,
    masses: &str,
    surfaces: Option<PathBuf>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Diagnosis> {
    let mass = mass_options(masses, surfaces)?;
    let found = |set: &Vec<PyRef<'_, Recording>>| model.subjects(set, &mass);
    let data = found(&data)?;
    let test = test.as_ref().map(found).transpose()?;
    let baseline = baseline.as_ref().map(found).transpose()?;
    let diagnosis_settings =
        DiagnosisSettings::parse("", &changes).map_err(|e| settings(e.to_string()))?;
    let mut options = DiagnoseOptions {
        seed,
        settings: diagnosis_settings,
        allow_implausible: accept,
        noise,
        law,
        ..DiagnoseOptions::default()
    };
    if let Some(ids) = effects {
        options.candidates = with_ids(&ids)?;
    }
    options.ladder = ladder.map(|(name, ids)| ladder_of(name, &ids)).transpose()?;
    let sets = RecordingSets { data: &data, test: test.as_deref(), baseline: baseline.as_deref() };
    let diagnosis = watched(py, |stop| {
        pam_diagnose::diagnose(&model.extended, &sets, &options, &|stage, share| {
            stop.check();
            let (what, share) = stage.progress(share);
            let (task, what) =
                if stage == Stage::Learning { (what, "") } else { ("diagnosing", what) };
            stop.call(progress.as_ref(), (task, share, what));
        })
    })?
    .map_err(raised)?;
    let context = ReportContext {
        model: model.saved.info.name.clone(),
        model_line: describe_model(&model.saved),
        made_by: pam_cli::run_record::made_by(),
        ..ReportContext::default()
    };
    let provenance = model.saved.info.provenance.clone();
    Ok(Diagnosis { diagnosis, context, provenance })
}

/// Measured, before and after: each `[samples, channels]`.
type Traces<'py> = (
    String,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Vec<Bound<'py, PyArray1<f64>>>,
    Vec<Bound<'py, PyArray1<f64>>>,
    Vec<Bound<'py, PyArray1<f64>>>,
);

#[pymethods]
impl Diagnosis {
    /// The result as JSON, as in `diagnosis.json`.
    fn json(&self) -> String {
        self.diagnosis.to_json("").to_string()
    }

    /// The verdict in a sentence.
    fn sentence(&self) -> String {
        verdict_sentence(&self.diagnosis)
    }

    /// The page `report.html`.
    fn report(&self) -> String {
        diagnosis_report(&self.diagnosis, &self.context)
    }

    /// The extended model.
    fn model(&self) -> PyResult<Model> {
        let mut saved = self.diagnosis.model.extended.to_saved();
        if self.diagnosis.is_extended() {
            saved.info.provenance = format!("{}; extended by a diagnosis", self.provenance);
        }
        Model::of(saved)
    }

    /// Keys and labels of the measured channels.
    fn channels(&self) -> Vec<(String, String)> {
        let channels = &self.diagnosis.error_reduction.channels;
        channels.iter().map(|c| (c.key.clone(), c.label.clone())).collect()
    }

    /// Test recordings before and after: name, time, excitation, and one array per channel each for measured, before, after.
    fn traces<'py>(&self, py: Python<'py>) -> Vec<Traces<'py>> {
        let array = |values: &[f64]| PyArray1::from_slice(py, values);
        let all = |channels: &[Vec<f64>]| channels.iter().map(|c| array(c)).collect();
        let traces = self.diagnosis.traces.iter();
        traces
            .map(|t| {
                let (time, excitation) = (array(&t.time_s), array(&t.excitation));
                (t.name.clone(), time, excitation, all(&t.measured), all(&t.before), all(&t.after))
            })
            .collect()
    }

    /// Excitations that separate the named cause from those with which it is confusable, best first: name, separation in
    /// multiples of the noise, and pieces `[force_n, frequency_hz, duration_s]`.
    fn design<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Vec<(String, f64, Bound<'py, PyArray2<f64>>)>> {
        let all = watched(py, |_| self.diagnosis.design())?;
        let one = |s: &pam_diagnose::joint::Separation| {
            (s.excitation.name.to_string(), s.least(), rows(py, &s.excitation.pieces))
        };
        Ok(all.iter().map(one).collect())
    }
}
