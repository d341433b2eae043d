//! `pam evaluate`.

use super::RunCommand;
use super::simulate::added_effect;
use crate::PARTIAL;
use crate::arguments::GlobalOptions;
use crate::console::{Console, table};
use crate::error::CliError;
use crate::memory::return_large_blocks;
use crate::options::{DataOptions, ModelOptions, SolverOptions, describe_model, solver_json};
use crate::output::Output;
use crate::run_record::{self, made_by, write_json};
use clap::Args;
use pam_data::atomic::write_atomic;
use pam_data::formats::csv_columns;
use pam_data::{Channel, SavedModel, Subject};
use pam_effects::ExtendedModel;
use pam_report::page::number;
use pam_report::{EvaluationContext, evaluation_report};
use pam_train::{Evaluation, RecordingEvaluation, evaluate_joint};
use pam_trajectory::{SolverSettings, StepChoice};
use serde::Serialize;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;

/// Arguments of `pam evaluate`.
#[derive(Debug, Args)]
pub struct EvaluateArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// Recordings, or folders of them
    #[arg(long, required = true, num_args = 1.., value_name = "PATH")]
    pub data: Vec<PathBuf>,
    /// Effect that is added to the model, as in coulomb_friction:force_n=12; may be given several times (`pam parts` lists
    /// them)
    #[arg(long = "effect", value_name = "ID:NAME=VALUE,…")]
    pub effects: Vec<String>,
    /// Folder for evaluation.json, report.html, run.json and predictions/
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Which samples predictions/ gets
    #[arg(long, value_enum, default_value_t, value_name = "WHICH")]
    pub predictions: WrittenPredictions,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
    /// How the equations are solved.
    #[command(flatten)]
    pub solver: SolverOptions,
}

/// Which samples of predictions are written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum WrittenPredictions {
    /// Every sample of up to two million in all recordings together, every n-th one of more
    #[default]
    Thinned,
    /// Every sample
    All,
    /// None: no such folder
    None,
}

/// Largest total number of samples in thinned predictions and in the data behind the figures; about 200 MB of CSV.
const MOST_SAMPLES: usize = 2_000_000;

impl RunCommand for EvaluateArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::Folder("evaluate", &self.out)]
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        return_large_blocks();
        let mut saved = self.model.load_extended(global.rig_for(&self.data)?.as_ref())?;
        for text in &self.effects {
            saved.info.effects.push(json!(added_effect(text)?));
        }
        let settings = self.solver.settings_for(&saved)?;
        let reading = self.reading.for_model(!saved.info.effects.is_empty());
        let subjects = reading.subjects(&self.data, &saved, global, console)?;
        let configuration = json!({
            "model": self.model.model,
            "activation": self.model.activation.map(|a| a.name()),
            "effects": saved.info.effects,
            "data": self.data,
            "reading": self.reading.to_json(global)?,
            "solver": solver_json(&settings),
            "predictions": self.predictions,
        });
        let predictions = self.predictions;
        let outcome = evaluate_into(&self.out, &saved, subjects, &settings, predictions, console)?;
        run_record::write(&self.out, "evaluate", global.seed, &configuration)?;
        Ok(outcome.finish(&self.out, console))
    }
}

/// Result of an evaluation as text and as JSON.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The evaluation.
    pub evaluation: Evaluation,
    /// The content of `evaluation.json`.
    pub json: Value,
}

/// Evaluates and writes `evaluation.json`, `report.html` and, as asked for, `predictions/NAME.csv` into a folder.
///
/// # Errors
/// [`CliError`] if a file cannot be written, or the model has an effect that is not known.
pub fn evaluate_into(
    folder: impl AsRef<Path>,
    saved: &SavedModel,
    subjects: Vec<Subject>,
    settings: &SolverSettings,
    predictions: WrittenPredictions,
    console: &Console,
) -> Result<Outcome, CliError> {
    let folder = folder.as_ref();
    let extended = ExtendedModel::from_saved(saved.clone())?;
    let samples: usize = subjects.iter().map(|s| s.recording.len()).sum();
    let stride = samples.div_ceil(MOST_SAMPLES).max(1);
    let failed_write = Mutex::new(None);
    let write = |r: &RecordingEvaluation| {
        let path = folder.join("predictions").join(format!("{}.csv", r.recording.name));
        let predicted = r.prediction.to_recording(&r.recording, r.masses);
        let text = csv_columns::to_csv(&predicted, Some(r.masses));
        if let Err(e) = write_atomic(&path, text.as_bytes()) {
            failed_write.lock().expect("no writer panics").get_or_insert(e);
        }
    };
    // Predictions are written and thinned one by one, because all of them together need as much memory as the recordings.
    let keep = |r: RecordingEvaluation| {
        if predictions == WrittenPredictions::All {
            write(&r);
        }
        let kept = if stride > 1 { r.every(stride) } else { r };
        if predictions == WrittenPredictions::Thinned {
            write(&kept);
        }
        kept
    };
    let bar = console.progress(subjects.len(), "predicting");
    let evaluation =
        evaluate_joint(&extended, &saved.model, subjects, settings, &keep, &|| bar.inc(1));
    bar.finish_and_clear();
    if let Some(e) = failed_write.into_inner().expect("no writer panics") {
        return Err(e.into());
    }
    let of_steps = |r: &&RecordingEvaluation| r.prediction.statistics.evaluations > 0;
    let integrated = evaluation.recordings.iter().filter(of_steps).count();
    if matches!(settings.step, StepChoice::SurrogateElse { .. }) && integrated > 0 {
        console.warn(format!(
            "in {integrated} of {} recordings the network bends too sharply for a surrogate: {} predicts them",
            evaluation.recordings.len(),
            settings.tableau.name
        ));
    }
    let context = EvaluationContext {
        model: saved.info.clone(),
        model_line: describe_model(saved),
        solver_line: settings.describe(),
        trained_on: saved.info.trained_on.clone(),
        made_by: made_by(),
    };
    let json = result_json(&evaluation, saved, settings);
    write_json(folder.join("evaluation.json"), &json)?;
    let report = evaluation_report(&evaluation, &saved.model, &context);
    write_atomic(folder.join("report.html"), report.as_bytes())?;
    Ok(Outcome { evaluation, json })
}

fn result_json(evaluation: &Evaluation, saved: &SavedModel, settings: &SolverSettings) -> Value {
    let mut value = evaluation.to_json();
    let p = saved.model.physical();
    value["model"] = json!({
        "name": saved.info.name,
        "provenance": saved.info.provenance,
        "force": saved.model.force.kind(),
        "mass_kg": p.mass_kg,
        "gas_coefficient_kpa_mm3_per_g": p.gas_coefficient,
        "deformation": p.deformation,
        "effects": saved.info.effects,
    });
    value["solver"] = json!(settings.describe());
    value["made_by"] = json!(made_by());
    value
}

impl Outcome {
    /// Prints the results and says with which code to end.
    #[must_use]
    pub fn finish(&self, folder: impl AsRef<Path>, console: &Console) -> ExitCode {
        let folder = folder.as_ref();
        console.json(&self.json);
        console.text(summary(&self.evaluation));
        let failed = &self.evaluation.failed;
        for f in failed {
            console.warn(format!("{} could not be predicted: {}", f.name, f.why));
        }
        console.text(format!("\nreport: {}", folder.join("report.html").display()));
        if failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(PARTIAL) }
    }
}

/// Most rows of the printed table; the rest is in the files.
const MOST_ROWS: usize = 30;

fn summary(evaluation: &Evaluation) -> String {
    let row = |name: &str, s: &pam_trajectory::Scores| {
        let mut cells = vec![name.to_owned()];
        cells.extend(Channel::ALL.map(|c| number(s.r2.get(c), 4)));
        cells.extend(Channel::ALL.map(|c| number(s.rmse.get(c), 4)));
        cells
    };
    let mut rows = vec![
        ["recording", "R² x", "R² v", "R² pf", "R² pe", "RMSE x", "v", "pf", "pe"]
            .map(str::to_owned)
            .to_vec(),
    ];
    for r in evaluation.recordings.iter().take(MOST_ROWS) {
        rows.push(row(&r.recording.name, &r.scores));
    }
    if evaluation.recordings.len() > MOST_ROWS {
        rows.push(vec![format!("… {} more", evaluation.recordings.len() - MOST_ROWS)]);
    }
    rows.push(row("mean", &evaluation.mean));
    let mut text = table(&rows);
    text += "\n  (RMSE in mm, mm/s, kPa, kPa)";
    if let [only] = &evaluation.recordings[..] {
        let b = &only.balance;
        text += &format!(
            "\n\n  On the measured motion the model lacks a force of {:.1} N (RMS); a part of {:+.1} N \
             flips with\n  the direction of motion and explains {:.0} % of its variance while moving.",
            b.rms_n,
            b.direction_n,
            100.0 * b.direction_share
        );
    }
    text
}
