//! `pam track`.

use super::{maker, rig};
use crate::arguments::{GlobalOptions, TrackArguments};
use crate::console::{Console, table};
use crate::error::CliError;
use crate::run_record::{self, made_by, write_json};
use pam_control::experiments::tracking::{published_cases, track};
use pam_control::report::tracking_report;
use pam_data::atomic::write_atomic;
use pam_report::page::number;
use serde_json::{Value, json};
use std::process::ExitCode;

/// Runs the command.
///
/// # Errors
/// [`CliError`] naming the option or file.
pub fn run(
    arguments: &TrackArguments,
    global: &GlobalOptions,
    console: &Console,
) -> Result<ExitCode, CliError> {
    let saved = arguments.model.load()?;
    let settings = arguments.bounds.settings(&saved.model)?;
    let rig = rig(arguments.rig.as_deref())?;
    let wanted = |list: &[String], name: &str| list.is_empty() || list.iter().any(|l| l == name);
    let mut cases = published_cases();
    cases.retain(|c| wanted(&arguments.shapes, c.shape) && wanted(&arguments.series, c.series));
    let bar = console.progress(cases.len(), "tracking");
    let results = track(&saved.model, settings, &cases, global.seed, &maker(&rig), &|| bar.inc(1))?;
    bar.finish_and_clear();
    let rows: Vec<Value> = results
        .iter()
        .map(|r| {
            json!({
                "case": r.case,
                "rmse_mm": r.rmse_mm,
                "pressure_rmse_kpa": r.pressure_rmse_kpa,
                "plan": r.plan,
            })
        })
        .collect();
    let out = &arguments.out;
    let value = json!({ "results": rows, "made_by": made_by() });
    write_json(&out.join("tracking.json"), &value)?;
    let mut text = String::from(
        "shape,series,amplitude_mm,frequency_hz,stiffness_n_mm,rmse_mm,published_mm,pressure_rmse_kpa\n",
    );
    let mut printed = vec![
        ["motion", "A (mm)", "f (Hz)", "K (N/mm)", "RMSE (mm)", "published", "pressure (kPa)"]
            .map(str::to_owned)
            .to_vec(),
    ];
    for r in &results {
        let c = &r.case;
        text += &format!(
            "{},{},{},{},{},{},{},{}\n",
            c.shape,
            c.series,
            c.amplitude_mm,
            c.frequency_hz,
            c.stiffness_n_mm,
            r.rmse_mm,
            c.published_mm,
            r.pressure_rmse_kpa
        );
        printed.push(vec![
            c.shape.into(),
            c.amplitude_mm.to_string(),
            c.frequency_hz.to_string(),
            c.stiffness_n_mm.to_string(),
            number(r.rmse_mm, 3),
            number(c.published_mm, 3),
            number(r.pressure_rmse_kpa, 1),
        ]);
    }
    write_atomic(&out.join("tracking.csv"), text.as_bytes())?;
    let lead = format!(
        "Commands of {}, tracked by the pulse servo of the virtual rig, seed {}. The error counts from the \
         second period on.",
        saved.info.name, global.seed
    );
    write_atomic(
        &out.join("report.html"),
        tracking_report(&results, &lead, &made_by()).as_bytes(),
    )?;
    let configuration = json!({
        "model": arguments.model.model,
        "settings": settings,
        "rig": rig,
        "shapes": arguments.shapes,
        "series": arguments.series,
    });
    run_record::write(out, "track", global.seed, &configuration)?;
    console.json(&value);
    console.text(table(&printed));
    console.text(format!("\nreport: {}", out.join("report.html").display()));
    Ok(ExitCode::SUCCESS)
}
