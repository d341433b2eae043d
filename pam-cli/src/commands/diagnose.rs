//! `pam diagnose`.

use crate::arguments::{DiagnoseArguments, GlobalOptions};
use crate::console::Console;
use crate::error::{CliError, failed, usage};
use crate::options::describe_model;
use crate::run_record::{self, made_by, write_json};
use indicatif::ProgressBar;
use pam_data::atomic::write_atomic;
use pam_data::models::save_model;
use pam_data::{DataError, SavedModel, Subject};
use pam_diagnose::report::{ReportContext, diagnosis_report, verdict_sentence};
use pam_diagnose::{
    DiagnoseOptions, DiagnosisSettings, JointDiagnosis, RecordingSets, Stage, diagnose,
};
use pam_effects::ExtendedModel;
use pam_effects::effects::{ALL, VocabularyError, by_id};
use pam_rig::protocol::CurrentSegment;
use pam_rig::{Conditions, Protocol};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs the command.
///
/// # Errors
/// [`CliError`] naming file, line and column, or the option. A verdict is no error.
pub fn run(
    arguments: &DiagnoseArguments,
    global: &GlobalOptions,
    console: &Console,
) -> Result<ExitCode, CliError> {
    let options = options(arguments, global.seed)?;
    let saved = arguments.model.load_extended()?;
    let read = |paths: &[PathBuf]| -> Result<Option<Vec<Subject>>, CliError> {
        if paths.is_empty() {
            return Ok(None);
        }
        Ok(Some(arguments.reading.subjects(paths, &saved, console)?))
    };
    let data = read(&arguments.data)?.unwrap_or_default();
    let test = read(&arguments.heldout)?;
    let baseline = read(&arguments.healthy)?;
    let sets = RecordingSets { data: &data, test: test.as_deref(), baseline: baseline.as_deref() };
    let diagnosis = diagnose_into(&arguments.out, &saved, &sets, &options, console)?;
    let configuration = json!({
        "model": arguments.model.model,
        "data": arguments.data,
        "heldout": arguments.heldout,
        "healthy": arguments.healthy,
        "effects": options.candidates.iter().map(|e| e.info().id).collect::<Vec<_>>(),
        "settings": options.settings,
        "reading": arguments.reading.to_json()?,
    });
    run_record::write(&arguments.out, "diagnose", global.seed, &configuration)?;
    if arguments.design {
        write_design(&diagnosis, &arguments.out, console)?;
    }
    finish(&diagnosis, &arguments.out, console);
    Ok(ExitCode::SUCCESS)
}

fn options(arguments: &DiagnoseArguments, seed: u64) -> Result<DiagnoseOptions, CliError> {
    if arguments.max_effects == Some(0) {
        return Err(CliError::Usage("--max-effects must be at least 1".into()));
    }
    let text = match &arguments.settings {
        Some(path) => {
            let text = std::fs::read_to_string(path).map_err(|e| DataError::io(path, e))?;
            DiagnosisSettings::parse(&text, &[])
                .map_err(|e| failed(format!("{}: {e}", path.display())))?;
            text
        }
        None => String::new(),
    };
    let most = arguments.max_effects.map(|most| format!("search.max_causes={most}"));
    let changes: Vec<String> = arguments.overrides.iter().cloned().chain(most).collect();
    let settings = DiagnosisSettings::parse(&text, &changes).map_err(usage)?;
    let mut options = DiagnoseOptions { seed, settings, ..DiagnoseOptions::default() };
    if !arguments.effects.is_empty() {
        options.candidates = arguments
            .effects
            .iter()
            .map(|id| {
                by_id(id.trim()).ok_or_else(|| {
                    let known = ALL.iter().map(|e| e.info().id);
                    let error = VocabularyError::unknown_effect(id.trim(), known);
                    CliError::Usage(format!("--effects: {error}"))
                })
            })
            .collect::<Result<_, _>>()?;
    }
    Ok(options)
}

/// Diagnoses and writes `diagnosis.json`, `report.html` and `model.safetensors` into a folder.
///
/// # Errors
/// [`CliError`] if there is too little data, the model diverges, or a file cannot be written.
pub fn diagnose_into(
    folder: &Path,
    saved: &SavedModel,
    sets: &RecordingSets<'_>,
    options: &DiagnoseOptions,
    console: &Console,
) -> Result<JointDiagnosis, CliError> {
    let model = ExtendedModel::from_saved(saved.clone())?;
    let bar = console.progress(1000, "diagnosing");
    let diagnosis = diagnose(&model, sets, options, &|stage, share| show(&bar, stage, share))?;
    bar.finish_and_clear();
    let mut extended = diagnosis.model.extended.to_saved();
    if !diagnosis.causes.is_empty() {
        extended.info.provenance = format!("{}; extended by a diagnosis", saved.info.provenance);
    }
    let path = folder.join("model.safetensors");
    save_model(&path, &extended)?;
    write_json(&folder.join("diagnosis.json"), &diagnosis.to_json("model.safetensors"))?;
    let context = ReportContext {
        model: saved.info.name.clone(),
        model_line: describe_model(saved),
        made_by: made_by(),
    };
    let report = diagnosis_report(&diagnosis, &context);
    write_atomic(&folder.join("report.html"), report.as_bytes())?;
    Ok(diagnosis)
}

/// Writes `design.toml`, a protocol for the rig, and `design.json`, how well each excitation separates.
fn write_design(
    diagnosis: &JointDiagnosis,
    folder: &Path,
    console: &Console,
) -> Result<(), CliError> {
    let all = diagnosis.design();
    write_json(&folder.join("design.json"), &json!(all))?;
    let Some(best) = all.first() else {
        console.text("Nothing is confusable: there is no experiment to design.");
        return Ok(());
    };
    let per_ampere = pam_core::units::tendon_force_mn_per_a() / pam_core::units::MN_PER_N;
    let protocol = Protocol {
        name: "design".into(),
        conditions: Some(Conditions::List(best.psi.iter().map(|p| p.map(|v| v as u8)).collect())),
        current: best
            .excitation
            .pieces
            .iter()
            .map(|&[force_n, frequency_hz, duration_s]| CurrentSegment::Sine {
                amplitude_a: (1e3 * force_n / per_ampere).round() / 1e3,
                frequency_hz,
                duration_s,
            })
            .collect(),
        ..Protocol::paper()
    };
    let path = folder.join("design.toml");
    write_atomic(&path, protocol.to_toml().as_bytes())?;
    console.text(format!(
        "Excitation that separates best ({}; {:.1} times the noise): {}\n",
        best.excitation.name,
        best.least(),
        path.display()
    ));
    Ok(())
}

fn show(bar: &ProgressBar, stage: Stage, share: f64) {
    let (from, to, what) = match stage {
        Stage::Preparing => (0.0, 0.05, "preparing"),
        Stage::Baseline => (0.05, 0.35, "baseline discrepancy"),
        Stage::Searching => (0.35, 0.9, "trying causes"),
        Stage::Judging => (0.9, 1.0, "measuring"),
    };
    bar.set_message(what);
    bar.set_position((1000.0 * (from + share * (to - from))) as u64);
}

/// Prints what was found.
pub fn finish(diagnosis: &JointDiagnosis, folder: &Path, console: &Console) {
    console.json(&diagnosis.to_json(&folder.join("model.safetensors").display().to_string()));
    console.text(format!("{}\n\n{}", diagnosis.verdict, verdict_sentence(diagnosis)));
    for cause in &diagnosis.causes {
        if !cause.confusable_with.is_empty() {
            console.text(format!(
                "{} is confusable with {} in these recordings.",
                cause.effect,
                cause.confusable_with.join(", ")
            ));
        }
    }
    let reduction = &diagnosis.error_reduction;
    let (x, overall) = (&reduction.channels[0], &reduction.overall);
    console.text(format!(
        "\n{}\nx: RMSE {:.4} -> {:.4} mm, R² {:.4} -> {:.4}; overall error {:+.0} % [{:.0}, {:.0}].",
        diagnosis.test.sentence(),
        x.rmse_before,
        x.rmse_after,
        x.r2_before,
        x.r2_after,
        -100.0 * overall.error_reduction,
        -100.0 * overall.ci95[1],
        -100.0 * overall.ci95[0],
    ));
    console.text(format!("\nreport: {}", folder.join("report.html").display()));
}
