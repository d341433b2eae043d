//! `pam track`.

use super::{BoundsOptions, maker, rig};
use crate::arguments::GlobalOptions;
use crate::commands::RunCommand;
use crate::console::{Console, table};
use crate::error::CliError;
use crate::options::ModelOptions;
use crate::output::Output;
use crate::run_record::{self, made_by, write_json};
use clap::Args;
use clap::builder::PossibleValuesParser;
use pam_control::experiments::tracking::{SERIES, SHAPES, published_cases, track};
use pam_control::report::tracking_report;
use pam_data::atomic::write_atomic;
use pam_report::page::number;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `pam track`.
#[derive(Debug, Args)]
pub struct TrackArguments {
    /// The model that plans.
    #[command(flatten)]
    pub model: ModelOptions,
    /// The bounds.
    #[command(flatten)]
    pub bounds: BoundsOptions,
    /// Parameters of the rig: default, measured (as rough as the published real run), or a TOML file; what that leaves
    /// out has its default
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub rig: String,
    /// Only tests of these shapes
    #[arg(long, value_delimiter = ',', value_name = "NAME,…", value_parser = PossibleValuesParser::new(SHAPES))]
    pub shapes: Vec<String>,
    /// Only tests of these series
    #[arg(long, value_delimiter = ',', value_name = "NAME,…", value_parser = PossibleValuesParser::new(SERIES))]
    pub series: Vec<String>,
    /// Folder for tracking.csv, tracking.json, report.html and run.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

impl RunCommand for TrackArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::Folder("track", &self.out)]
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let saved = self.model.load(global.rig()?.as_ref())?;
        let settings = self.bounds.settings(&saved, global)?;
        let rig = rig(&self.rig)?;
        let wanted =
            |list: &[String], name: &str| list.is_empty() || list.iter().any(|l| l == name);
        let mut cases = published_cases();
        cases.retain(|c| wanted(&self.shapes, c.shape) && wanted(&self.series, c.series));
        let bar = console.progress(cases.len(), "tracking");
        let results =
            track(&saved.model, settings, &cases, global.seed, &maker(&rig), &|| bar.inc(1))?;
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
        let out = &self.out;
        let value = json!({ "results": rows, "made_by": made_by() });
        write_json(out.join("tracking.json"), &value)?;
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
        write_atomic(out.join("tracking.csv"), text.as_bytes())?;
        let lead = format!(
            "Commands of {}, tracked by the pulse servo of the virtual rig, seed {}. The error counts from the \
         second period on.",
            saved.info.name, global.seed
        );
        write_atomic(
            out.join("report.html"),
            tracking_report(&results, &lead, &made_by()).as_bytes(),
        )?;
        let configuration = json!({
            "model": self.model.model,
            "settings": settings,
            "rig": rig,
            "shapes": self.shapes,
            "series": self.series,
        });
        run_record::write(out, "track", global.seed, &configuration)?;
        console.json(&value);
        console.text(table(&printed));
        console.text(format!("\nreport: {}", out.join("report.html").display()));
        Ok(ExitCode::SUCCESS)
    }
}
