//! The cases at work: in parallel, in shards, resumable.

use super::case::{Case, Outcome, Plan};
use crate::error::ExperimentError;
use crate::plan::Synthesis;
use pam_data::atomic::write_atomic;
use pam_data::{DataError, Subject, document, read_limit};
use pam_diagnose::{BaselineDiscrepancy, DiagnoseOptions, RecordingSets, diagnose};
use pam_effects::ExtendedModel;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// The folder of a certificate: `plan.json`, and one file for each case that is over.
#[derive(Debug, Clone)]
pub struct CertifyFolder(PathBuf);

impl CertifyFolder {
    /// The folder of a certificate, begun or not.
    #[must_use]
    pub fn at(path: impl AsRef<Path>) -> Self {
        Self(path.as_ref().to_owned())
    }

    /// Writes the plan, or checks that the folder has the same one. `inputs` is everything else that decides the outcomes.
    ///
    /// # Errors
    /// [`ExperimentError::Folder`] if the folder was begun with another plan.
    pub fn begin<T: Serialize>(&self, plan: &Plan, inputs: &T) -> Result<(), ExperimentError> {
        let text = to_json(&serde_json::json!({ "plan": plan, "inputs": inputs }))?;
        let path = self.0.join("plan.json");
        match read_limit::read_text(&path) {
            Ok(there) if there == text => Ok(()),
            Ok(_) => Err(ExperimentError::Folder {
                path,
                message: "the folder holds the cases of another certificate (model, recordings, effects or settings \
                          differ); give another --out"
                    .into(),
            }),
            Err(e) if e.is_missing() => Ok(write_atomic(&path, text.as_bytes())?),
            Err(e) => Err(e.into()),
        }
    }

    fn case(&self, case: &Case) -> PathBuf {
        self.0.join("cases").join(format!("{}.json", case.id))
    }

    /// The outcomes of cases that are over.
    ///
    /// # Errors
    /// [`ExperimentError::Data`] naming the file that cannot be read.
    pub fn outcomes(&self, plan: &Plan) -> Result<Vec<Outcome>, ExperimentError> {
        let read = |case: &Case| read::<Outcome>(&self.case(case)).transpose();
        plan.cases.iter().filter_map(read).collect()
    }
}

fn to_json<T: Serialize>(value: &T) -> Result<String, ExperimentError> {
    let text =
        document::to_json(value).map_err(|e| ExperimentError::setting("plan", e.message()))?;
    Ok(format!("{text}\n"))
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, ExperimentError> {
    match read_limit::read_text(path) {
        Ok(text) => document::from_json(&text).map(Some).map_err(|e| {
            let message = format!("{}; remove the file to have the case run again", e.message());
            DataError::line(path, e.line(&text), message).into()
        }),
        Err(e) if e.is_missing() => Ok(None),
        Err(e) => Err(e.into()),
    }
}

/// Progress of the cases of a process.
#[derive(Debug, Clone, Copy)]
pub enum Progress<'a> {
    /// So many cases are to be run, and so many of the share are over already.
    Planned(usize, usize),
    /// A case is over.
    Over(&'a Outcome),
}

/// The options for every diagnosis of a certificate: the discrepancy of the model is learned from the baseline recordings once.
///
/// # Errors
/// [`ExperimentError`] if the recordings are too short or the model diverges on them.
pub fn with_baseline(
    model: &ExtendedModel,
    baseline: &[Subject],
    diagnosis: &DiagnoseOptions,
) -> Result<DiagnoseOptions, ExperimentError> {
    let learned = BaselineDiscrepancy::learn(model, baseline, diagnosis, &|_| {})?;
    Ok(DiagnoseOptions { discrepancy: Some(learned), ..diagnosis.clone() })
}

/// What the cases of a certificate are run with.
#[derive(Debug, Clone, Copy)]
pub struct Work<'a> {
    /// The model.
    pub model: &'a ExtendedModel,
    /// Baseline recordings that every diagnosis is given.
    pub baseline: &'a [Subject],
    /// Where recordings with effects come from.
    pub synthesis: &'a Synthesis,
    /// The cases.
    pub plan: &'a Plan,
    /// The diagnosis that is certified, [with the baseline](with_baseline).
    pub diagnosis: &'a DiagnoseOptions,
    /// Where the outcomes are written.
    pub folder: &'a CertifyFolder,
}

/// Runs the cases of a share that are not over, `jobs` at a time with one thread each. Returns whether all of the share are
/// over; `stop` ends it after the cases at work.
///
/// # Errors
/// [`ExperimentError`] if the folder cannot be written to. A case whose diagnosis fails is an outcome.
pub fn run_cases(
    work: &Work<'_>,
    own: &(dyn Fn(usize) -> bool + Sync),
    jobs: usize,
    stop: &AtomicBool,
    progress: &(dyn Fn(Progress<'_>) + Sync),
) -> Result<bool, ExperimentError> {
    let Work { plan, folder, .. } = *work;
    let mine: Vec<&Case> =
        plan.cases.iter().enumerate().filter(|(k, _)| own(*k)).map(|(_, c)| c).collect();
    let mut due = VecDeque::new();
    for case in &mine {
        if read::<Outcome>(&folder.case(case))?.is_none() {
            due.push_back(*case);
        }
    }
    let cases = folder.0.join("cases");
    std::fs::create_dir_all(&cases).map_err(|e| DataError::io(&cases, e))?;
    progress(Progress::Planned(due.len(), mine.len() - due.len()));
    let jobs = jobs.clamp(1, due.len().max(1));
    let (queue, error) = (Mutex::new(due), Mutex::new(None));
    let worker = || {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        while !stop.load(Ordering::Relaxed) {
            let Some(case) = queue.lock().ok().and_then(|mut q| q.pop_front()) else { return };
            let outcome = || one(work, case);
            let outcome = match &pool {
                Ok(pool) => pool.install(outcome),
                Err(_) => outcome(),
            };
            let written = to_json(&outcome)
                .and_then(|text| Ok(write_atomic(folder.case(case), text.as_bytes())?));
            if let Err(e) = written {
                // Where one case cannot write, none can.
                stop.store(true, Ordering::Relaxed);
                if let Ok(mut first) = error.lock() {
                    first.get_or_insert(e);
                }
                return;
            }
            progress(Progress::Over(&outcome));
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(worker);
        }
    });
    match error.into_inner() {
        Ok(Some(e)) => Err(e),
        _ => Ok(!stop.load(Ordering::Relaxed)),
    }
}

fn one(work: &Work<'_>, case: &Case) -> Outcome {
    let clock = Instant::now();
    let (seed, shared) = (case.seed, work.diagnosis.clone());
    let options = DiagnoseOptions { seed, law: false, ladder: None, ..shared };
    let run = || -> Result<Outcome, ExperimentError> {
        let data = work.synthesis.set(case.active().as_ref(), case.seed)?;
        let sets = RecordingSets { data: &data, test: None, baseline: Some(work.baseline) };
        let found = diagnose(work.model, &sets, &options, &|_, _| {})?;
        Ok(Outcome::of(case, &found, clock.elapsed().as_secs_f64()))
    };
    let failed = |why: String| Outcome::refused(case, why, clock.elapsed().as_secs_f64());
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(outcome)) => outcome,
        Ok(Err(e)) => failed(e.to_string()),
        Err(_) => failed("the diagnosis ended with a panic".into()),
    }
}
