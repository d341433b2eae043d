//! The results of `pam train`: `training.json`, `report.html` and the printed table.

use crate::INTERRUPTED;
use crate::console::{Console, table};
use crate::error::CliError;
use crate::run_record::{made_by, write_json};
use pam_data::atomic::write_atomic;
use pam_report::page::number;
use pam_report::training::{EpochRow, ParameterRow, StageRow};
use pam_report::{TrainingReport, effect_curves, force_curves, training_report};
use pam_train::curriculum::Stage;
use pam_train::identification::{DeformationEstimate, Identification, MassEstimate};
use pam_train::training::{TrainedRun, Trainer};
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;

/// Writes and prints the results, and says with which code to end.
pub(super) fn finish(
    trainer: &Trainer,
    trained: &TrainedRun,
    out: &Path,
    console: &Console,
) -> Result<ExitCode, CliError> {
    let p = trainer.model().physical();
    // The regressions behind standard errors know no effects.
    let effects = trainer.effects();
    let found =
        if trained.finished && effects.is_empty() { Some(trainer.identify()?) } else { None };
    let rows = parameter_rows(trainer, found.as_ref());
    let value = json!({
        "finished": trained.finished,
        "stages": trained.results,
        "events": trained.events,
        "trained_on": trainer.trained_on(),
        // Null where the data do not determine the parameter; `model_parameters` has the values in the model.
        "parameters": {
            "mass_kg": rows[0].value,
            "gas_coefficient_kpa_mm3_per_g": p.gas_coefficient,
            "deformation": rows[2].value,
        },
        "model_parameters": {
            "mass_kg": p.mass_kg,
            "gas_coefficient_kpa_mm3_per_g": p.gas_coefficient,
            "deformation": p.deformation,
        },
        "effects": effects,
        "identification": found.as_ref().map(|found| json!({
            "mass": found.mass,
            "mass_doubt": found.mass.doubt(),
            "deformation": found.deformation,
            "deformation_doubt": found.deformation.doubt(),
        })),
        "made_by": made_by(),
    });
    write_json(out.join("training.json"), &value)?;
    write_atomic(out.join("report.html"), report(trainer, trained, rows.clone()).as_bytes())?;
    console.json(&value);
    if !trained.finished {
        console.text(format!("interrupted; go on with --resume --out {}", out.display()));
        return Ok(ExitCode::from(INTERRUPTED));
    }
    let mut cells =
        vec![["parameter", "value", "standard error", "unit"].map(str::to_owned).to_vec()];
    // C is left to the report: recordings of the joint alone do not determine it.
    for row in rows.iter().filter(|row| !row.name.starts_with("gas")) {
        let error = row.standard_error.map_or("–".into(), |e| format!("± {}", number(e, 4)));
        let value = row.value.map_or("withheld".into(), |value| number(value, 4));
        cells.push(vec![row.name.clone(), value, error, row.unit.clone()]);
    }
    let notes: String = rows
        .iter()
        .filter(|row| !row.name.starts_with("gas") && !row.note.is_empty())
        .map(|row| format!("\n  {}: {}", row.name, row.note))
        .collect();
    console.text(format!(
        "\n{}{notes}\n\nmodel: {}\nreport: {}",
        table(&cells),
        out.join("model.safetensors").display(),
        out.join("report.html").display()
    ));
    Ok(ExitCode::SUCCESS)
}

/// Values, standard errors and doubts.
fn parameter_rows(trainer: &Trainer, found: Option<&Identification>) -> Vec<ParameterRow> {
    let p = trainer.model().physical();
    let frozen = trainer.curriculum().coordinates.frozen;
    let row =
        |name: &str, unit: &str, value: Option<f64>, error: Option<f64>, note: Option<String>| {
            ParameterRow {
                name: name.into(),
                unit: unit.into(),
                value,
                // An error without its value would look like one.
                standard_error: value.and(error),
                note: note.unwrap_or_default(),
            }
        };
    let fixed = |is: bool| is.then(|| "fixed".to_owned());
    let mass = found.map(|f| &f.mass).filter(|_| !frozen.mass);
    let deformation = found.map(|f| &f.deformation).filter(|_| !frozen.deformation);
    let effects = trainer.effect_values().into_iter().map(|(name, value)| {
        let (effect, parameter) = name.split_once('.').unwrap_or(("", &name));
        let note = fixed(frozen.effects);
        row(
            &format!("{} {parameter}", effect.replace('_', " ")),
            "in its name",
            Some(value),
            None,
            note,
        )
    });
    let gas =
        "not identified: pressures show its product with the masses, which come from the same law";
    let mut rows = vec![
        row(
            "reflected mass m",
            "kg",
            mass.map_or(Some(p.mass_kg), MassEstimate::determined_kg),
            mass.and_then(|m| m.standard_error_kg),
            fixed(frozen.mass).or(mass.and_then(MassEstimate::doubt)),
        ),
        row("gas coefficient C", "kPa·mm³/g", Some(p.gas_coefficient), None, Some(gas.into())),
        row(
            "deformation ν",
            "1",
            deformation.map_or(Some(p.deformation), DeformationEstimate::determined),
            deformation.and_then(|d| d.standard_error),
            fixed(frozen.deformation).or(deformation.and_then(DeformationEstimate::doubt)),
        ),
    ];
    rows.extend(effects);
    rows
}

/// The report of a run.
fn report(trainer: &Trainer, trained: &TrainedRun, parameters: Vec<ParameterRow>) -> String {
    let numbers = |r2: [Option<f64>; 4]| r2.map(|v| v.unwrap_or(f64::NAN));
    let stages = trained.results.iter().map(|r| StageRow {
        name: r.name.clone(),
        epochs: r.epochs,
        seconds: r.seconds,
        loss_first: r.first_loss.unwrap_or(f64::NAN),
        loss_best: r.best_loss,
        r2_train: numbers(r.r2_train),
        r2_held: r.r2_held_out.iter().any(Option::is_some).then(|| numbers(r.r2_held_out)),
    });
    // Residuals of regressions are no losses.
    let solved = |stage: usize| matches!(trainer.curriculum().stages[stage], Stage::Solve(_));
    let history = trained.rows.iter().filter(|row| solved(row.stage)).map(|row| EpochRow {
        stage: row.stage,
        epoch: row.total_epoch,
        loss: row.loss,
        rate: row.rate,
        gradient_norm: row.gradient_norm,
        held_r2: row.r2_held_out.map(|r2| r2[0]),
    });
    let model = trainer.model();
    let curriculum = trainer.curriculum();
    let report = TrainingReport {
        title: match trained.results.last().map(|r| (r.r2_held_out[0], r.r2_train[0])) {
            Some((Some(r2), _)) => {
                format!(
                    "The trained model predicts held-out recordings with R² of x = {}",
                    number(r2, 3)
                )
            }
            Some((None, Some(r2))) => {
                format!(
                    "The trained model predicts its training recordings with R² of x = {}",
                    number(r2, 3)
                )
            }
            _ => "Training".to_owned(),
        },
        lead: format!(
            "Curriculum {}; {} recordings trained on, {} held out; {}.",
            curriculum.name,
            trainer.trained_on().len(),
            trainer.held_out_len(),
            if trained.finished { "all stages done" } else { "interrupted" }
        ),
        made_by: made_by(),
        stages: stages.collect(),
        history: history.collect(),
        events: trained.events.clone(),
        parameters,
    };
    let courses: Vec<(String, Vec<(f64, f64)>)> = trainer
        .effect_values()
        .into_iter()
        .enumerate()
        .map(|(k, (name, _))| {
            let course = trained.rows.iter().map(|row| (row.total_epoch as f64, row.effects[k]));
            (name, course.collect())
        })
        .collect();
    let mut sections = vec![("Learned force", force_curves(&model))];
    if !courses.is_empty() {
        sections.insert(0, ("Effects", effect_curves(&courses)));
    }
    training_report(&report, &sections)
}
