//! Training.

use crate::errors::{raised, settings};
use crate::loss::Loss;
use crate::model::Model;
use crate::recording::Recording;
use crate::watch::watched;
use pam_core::AnyForce;
use pam_data::{ModelInfo, MuscleSurfaces, SavedModel, document};
use pam_effects::ExtendedModel;
use pam_train::curriculum::{Curriculum, Selection, SelectionSet};
use pam_train::training::{
    EpochRow, RunFolder, RunSettings, TrainedRun, Trainer, TrainingError, effects_of, train_into,
};
use pyo3::prelude::*;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// The loss of a Python function in a training.
struct FunctionLoss {
    loss: Loss,
    /// The exception that the function raised.
    stop: Arc<crate::watch::Stop>,
}

impl pam_trajectory::TrajectoryLoss for FunctionLoss {
    fn value_and_cotangents(
        &self,
        measured: &pam_data::Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        self.loss.value_and_cotangents(measured, predicted, cotangents, &self.stop)
    }
}

/// Trains a model; returns it with the course of the training as JSON.
///
/// `curriculum` is a name, a path, or a whole curriculum as JSON. `start` is the path of the model to start from. With a
/// folder the run is kept there and goes on if it was begun there. `callback` is called with JSON after every epoch; if it
/// returns `False`, the training stops.
#[pyfunction]
#[pyo3(signature = (recordings, held_out, curriculum, *, changes, loss, surfaces, seed, folder, name, callback, progress))]
pub(crate) fn train(
    py: Python<'_>,
    recordings: Vec<PyRef<'_, Recording>>,
    held_out: Vec<PyRef<'_, Recording>>,
    curriculum: &str,
    changes: Vec<String>,
    loss: Option<&Bound<'_, PyAny>>,
    surfaces: Option<PathBuf>,
    seed: u64,
    folder: Option<PathBuf>,
    name: Option<String>,
    callback: Option<Py<PyAny>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Model, String)> {
    let curriculum = read_curriculum(curriculum, &changes)?;
    let all = |set: &[PyRef<'_, Recording>]| {
        set.iter().map(|r| (*r.inner).clone()).collect::<Vec<pam_data::Recording>>()
    };
    let (trained_on, mut every) = (all(&recordings), all(&recordings));
    every.extend(all(&held_out));
    if let Some(both) = held_out.iter().find(|h| trained_on.iter().any(|r| r.name == h.inner.name))
    {
        return Err(settings(format!(
            "`{}` is both trained on and held out; recordings are distinguished by their names",
            both.inner.name
        )));
    }
    let curriculum = Curriculum {
        data: pam_train::curriculum::DataSettings {
            train: Selection::Names(trained_on.iter().map(|r| r.name.clone()).collect()),
            held_out: Selection::Set(SelectionSet::Rest),
            ..curriculum.data.clone()
        },
        ..curriculum
    };
    let surfaces = surfaces.map(MuscleSurfaces::read).transpose().map_err(raised)?;
    let loss = loss.map(Loss::of).transpose()?;
    let raised_by_loss = Arc::new(crate::watch::Stop::default());
    let total: usize = curriculum.stages.iter().map(|s| s.epochs()).sum();
    let before: Vec<usize> = curriculum
        .stages
        .iter()
        .scan(0, |sum, s| Some(std::mem::replace(sum, *sum + s.epochs())))
        .collect();
    let names: Vec<String> = curriculum.stages.iter().map(|s| s.name().to_owned()).collect();
    let title = name.unwrap_or_else(|| format!("hybrid joint, {} (seed {seed})", curriculum.name));

    let result = watched(py, |stop| -> Result<(Trainer, TrainedRun), TrainingError> {
        let effects = effects_of(&curriculum, &[])?;
        let mut trainer = Trainer::extended(curriculum, every, surfaces, effects, seed)?;
        if let Some(loss) = loss {
            trainer = match loss {
                Loss::Named(named) => trainer.with_loss(named),
                function @ Loss::Function(_) => trainer
                    .with_loss(FunctionLoss { loss: function, stop: Arc::clone(&raised_by_loss) }),
            };
        }
        let observe = |row: &EpochRow| {
            if let Some(error) = raised_by_loss.reason() {
                stop.ask(error);
            }
            let share = (before[row.stage] + row.epoch) as f64 / total.max(1) as f64;
            let text = format!("{}, loss {:.4}", names[row.stage], row.loss);
            stop.call(progress.as_ref(), ("training", share, text));
            if let Some(function) = &callback {
                let mut value = json!(row);
                value["stage_name"] = json!(names[row.stage]);
                let goes_on = Python::attach(|py| {
                    let result = function.call1(py, (value.to_string(),))?;
                    Ok::<_, PyErr>(!result.bind(py).is(pyo3::types::PyBool::new(py, false)))
                });
                match goes_on {
                    Ok(true) => {}
                    Ok(false) => stop.end(),
                    Err(error) => stop.ask(error),
                }
            }
        };
        let run = match &folder {
            Some(path) => {
                let folder = RunFolder::new(path);
                let run_settings = RunSettings {
                    checkpoint_every: Duration::from_secs(10),
                    model_name: title.clone(),
                    made_by: pam_cli::run_record::made_by(),
                };
                let resume = folder.has_checkpoint();
                train_into(
                    &mut trainer,
                    &folder,
                    &run_settings,
                    resume,
                    stop.flag(),
                    &mut |row, _| {
                        observe(row);
                    },
                )?
            }
            None => in_memory(&mut trainer, stop.flag(), observe)?,
        };
        Ok((trainer, run))
    });
    // What a loss raised explains every later error.
    if let Some(error) = raised_by_loss.reason() {
        return Err(error);
    }
    let (trainer, run) = result?.map_err(raised)?;
    let model = trainer.model();
    let joint = model.map(|v| v, |force| AnyForce::Network(force.clone()));
    let info = ModelInfo {
        name: title,
        provenance: format!("trained by the curriculum {}", trainer.curriculum().name),
        trained: true,
        trained_on: trainer.trained_on(),
        rig: trainer.curriculum().model.rig.clone(),
        ..ModelInfo::default()
    };
    let extended = ExtendedModel { joint, info, effects: trainer.effects() };
    let saved: SavedModel = extended.to_saved();
    let value = json!({
        "finished": run.finished,
        "stages": run.results,
        "events": run.events,
        "epochs": run.rows,
        "stage_names": trainer.curriculum().stages.iter().map(|s| s.name()).collect::<Vec<_>>(),
        "trained_on": trainer.trained_on(),
    });
    Ok((Model::of(saved)?, value.to_string()))
}

fn in_memory(
    trainer: &mut Trainer,
    stop: &std::sync::atomic::AtomicBool,
    observe: impl Fn(&EpochRow),
) -> Result<TrainedRun, TrainingError> {
    let mut rows = Vec::new();
    let mut finished = true;
    while let Some(row) = trainer.advance()? {
        observe(&row);
        rows.push(row);
        if stop.load(std::sync::atomic::Ordering::Relaxed) {
            finished = trainer.is_done();
            break;
        }
    }
    let state = trainer.state();
    let (results, events) = (state.results.clone(), state.events.clone());
    Ok(TrainedRun { finished, results, events, rows })
}

/// A curriculum from a name, a path or JSON, with changes.
fn read_curriculum(text: &str, changes: &[String]) -> PyResult<Curriculum> {
    if !text.starts_with('{') {
        return Curriculum::open(text, changes).map_err(raised);
    }
    let value: serde_json::Value =
        serde_json::from_str(text).map_err(|e| settings(format!("curriculum: {e}")))?;
    let toml = document::to_toml(&value).map_err(|e| settings(format!("curriculum: {e}")))?;
    Curriculum::parse(&toml, Path::new("curriculum"), changes).map_err(raised)
}
