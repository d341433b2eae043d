//! `pam identify`.

use super::{BoundsOptions, maker, rig};
use crate::arguments::GlobalOptions;
use crate::commands::RunCommand;
use crate::console::{Console, table};
use crate::error::{CliError, failed};
use crate::options::ModelOptions;
use crate::output::Output;
use crate::run_record::{self, made_by, write_json};
use clap::{Args, ValueEnum};
use pam_control::equilibrium_point::{EquilibriumPoint, observe};
use pam_control::execution::{Commands, PulseShape};
use pam_control::experiments::stiffness::{
    Identified, STAIRCASE_N_MM, staircase, staircase_targets,
};
use pam_control::experiments::{comparison, on_model, stiffness};
use pam_control::identification::pulses_in_recording;
use pam_control::report::{IdentificationReport, identification_report};
use pam_control::synthesis::{Plan, PlanSummary};
use pam_core::parallel;
use pam_data::atomic::write_atomic;
use pam_data::{LoadOptions, Recording, SavedModel, open_recordings, read_recordings};
use pam_numerics::statistics::{mean, standard_deviation};
use pam_report::page::number;
use pam_rig::{Protocol, RigParameters, record};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Schedules of `pam identify`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum IdentifySchedule {
    /// 126 to 176 N/mm at rest
    Staircase,
    /// 140, 150, 160 N/mm on a sine of 1 mm at 0.1 Hz
    Cycle,
    /// The cycle with the learned model's and the equilibrium-point model's commands
    Compare,
}

/// Arguments of `pam identify`.
#[derive(Debug, Args)]
pub struct IdentifyArguments {
    /// The model that plans, and whose mass is taken.
    #[command(flatten)]
    pub model: ModelOptions,
    /// Schedule on the virtual rig
    #[arg(
        long,
        value_enum,
        default_value = "staircase",
        value_name = "NAME",
        conflicts_with = "data"
    )]
    pub schedule: IdentifySchedule,
    /// Identify from recordings instead: every pulse of force in them that follows 50 ms without
    #[arg(long, num_args = 1.., value_name = "PATH")]
    pub data: Vec<PathBuf>,
    /// Recordings to which the equilibrium-point model is fitted [default: the 29 training conditions on
    /// the rig]
    #[arg(long, num_args = 1.., value_name = "PATH")]
    pub recordings: Vec<PathBuf>,
    /// The bounds.
    #[command(flatten)]
    pub bounds: BoundsOptions,
    /// Parameters of the rig: default, measured (as rough as the published real run), or a TOML file; what that leaves
    /// out has its default
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub rig: String,
    /// Force of the pulses, N
    #[arg(long, value_name = "N", default_value_t = 90.0, allow_negative_numbers = true)]
    pub pulse_force: f64,
    /// Time from the start of a pulse that is fitted, ms
    #[arg(long, value_name = "MS", default_value_t = 150.0, allow_negative_numbers = true)]
    pub window: f64,
    /// How often a cycle is repeated, each time with another seed
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..))]
    pub repeats: u32,
    /// Folder for pulses.csv, identify.json, report.html and run.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

impl RunCommand for IdentifyArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::Folder("identify", &self.out)]
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let saved = self.model.load(global.rig()?.as_ref())?;
        let settings = self.bounds.settings(&saved, global)?;
        let shape = PulseShape {
            force_n: self.pulse_force,
            window_s: 1e-3 * self.window,
            ..PulseShape::default()
        };
        if !(shape.force_n.is_finite() && shape.force_n != 0.0) {
            return Err(CliError::Usage("--pulse-force must be finite and not zero".into()));
        }
        if !(0.05..=5.0).contains(&shape.window_s) {
            return Err(CliError::Usage("--window must lie between 50 and 5000 ms".into()));
        }
        let mass_kg = saved.model.physical().mass_kg;
        let mut report = IdentificationReport {
            title: "Identified stiffness".into(),
            made_by: made_by(),
            lead: format!("M = {mass_kg:.1} kg; pulses of {} N.", shape.force_n),
            ..IdentificationReport::default()
        };
        let mut extra = json!({});
        if self.data.is_empty() {
            let rig = rig(&self.rig)?;
            let plan = |targets| Plan::new(&saved.model, targets, settings);
            let make = maker(&rig);
            match self.schedule {
                IdentifySchedule::Staircase => {
                    let plan = plan(staircase_targets(&STAIRCASE_N_MM)?)?;
                    warn_of_plan(&plan.summary(), console);
                    let commands = Commands::from(&plan);
                    let levels = STAIRCASE_N_MM.len();
                    report.pulses =
                        staircase(&commands, levels, &shape, mass_kg, global.seed, &make)?;
                    let twin = on_model(&saved.model);
                    report.on_model = staircase(&commands, levels, &shape, mass_kg, 0, &twin)?;
                }
                IdentifySchedule::Cycle => {
                    let plan = plan(comparison::targets()?)?;
                    warn_of_plan(&plan.summary(), console);
                    let commands = Commands::from(&plan);
                    report.pulses =
                        stiffness::cycle(&commands, &shape, mass_kg, global.seed, &make)?;
                    let twin = on_model(&saved.model);
                    report.on_model = stiffness::cycle(&commands, &shape, mass_kg, 0, &twin)?;
                }
                IdentifySchedule::Compare => {
                    let targets = comparison::targets()?;
                    let plan = plan(targets.clone())?;
                    warn_of_plan(&plan.summary(), console);
                    let repeats = self.repeats as usize;
                    let model = equilibrium_point(self, &rig, global.seed, console)?;
                    let commands = [Commands::from(&plan), model.commands(&targets)];
                    let names = [saved.info.name.clone(), "equilibrium point".to_owned()];
                    for (commands, name) in commands.iter().zip(names) {
                        let (mut rows, pulses) = comparison::rows(
                            commands,
                            &shape,
                            mass_kg,
                            repeats,
                            global.seed,
                            &make,
                        )?;
                        comparison::explain(&mut rows, &saved.model, &targets, commands, &shape)?;
                        report.tables.push((name, rows));
                        if report.pulses.is_empty() {
                            report.pulses = pulses;
                        }
                    }
                    extra = json!({ "equilibrium_point": model });
                }
            }
        } else {
            report.pulses = from_recordings(&self.data, &shape, mass_kg)?;
        }
        finish(&report, &extra, self, &saved, global, console)
    }
}

fn warn_of_plan(plan: &PlanSummary, console: &Console) {
    if plan.nearest_stiffness > 0 {
        console.warn(format!(
            "{} of {} planned samples hold the nearest stiffness, at most {:.2} N/mm off",
            plan.nearest_stiffness, plan.samples, plan.largest_stiffness_error_n_mm
        ));
    }
}

/// The equilibrium-point model of given recordings, or of the training conditions on the rig.
fn equilibrium_point(
    arguments: &IdentifyArguments,
    rig: &RigParameters,
    seed: u64,
    console: &Console,
) -> Result<EquilibriumPoint, CliError> {
    let recordings: Vec<Recording> = if arguments.recordings.is_empty() {
        let protocol = Protocol::paper();
        let runs = protocol.runs()?;
        let bar = console.progress(runs.len(), "recording");
        let folder =
            tempfile::tempdir().map_err(|e| failed(format!("no folder for recordings: {e}")))?;
        let made = parallel::map(runs.len(), |k| {
            let run = &runs[k];
            let path = folder.path().join(&run.name);
            let log =
                record(rig, &protocol, run, seed)?.log_text("for the equilibrium-point model");
            write_atomic(&path, log.as_bytes())?;
            bar.inc(1);
            Ok(open_recordings(&path, &LoadOptions::default())?)
        })
        .into_iter()
        .collect::<Result<Vec<_>, CliError>>()?;
        bar.finish_and_clear();
        made.into_iter().flatten().collect()
    } else {
        read_recordings(&arguments.recordings, &LoadOptions::default())?
    };
    let observations = recordings.iter().map(observe).collect::<Result<Vec<_>, _>>()?;
    Ok(EquilibriumPoint::fit(&observations)?)
}

fn from_recordings(
    paths: &[std::path::PathBuf],
    shape: &PulseShape,
    mass_kg: f64,
) -> Result<Vec<Identified>, CliError> {
    let mut pulses = Vec::new();
    for recording in read_recordings(paths, &LoadOptions::default())? {
        let records = pulses_in_recording(&recording, shape)?;
        pulses.extend(stiffness::identify_all(records, mass_kg)?);
    }
    Ok(pulses)
}

fn finish(
    report: &IdentificationReport,
    extra: &Value,
    arguments: &IdentifyArguments,
    saved: &SavedModel,
    global: &GlobalOptions,
    console: &Console,
) -> Result<ExitCode, CliError> {
    let out: &Path = &arguments.out;
    let values = |pulses: &[Identified]| -> Vec<Value> {
        let value = |i: &Identified| {
            json!({
                "pulse": i.record.pulse,
                "commanded_n_mm": i.record.commanded_n_mm,
                "estimate": i.estimate,
            })
        };
        pulses.iter().map(value).collect()
    };
    let (estimates, on_model) = (values(&report.pulses), values(&report.on_model));
    let tables: Vec<Value> =
        report.tables.iter().map(|(name, rows)| json!({ "model": name, "rows": rows })).collect();
    let value = json!({
        "mass_kg": saved.model.physical().mass_kg,
        "pulses": estimates,
        "on_model": on_model,
        "tables": tables,
        "more": extra,
        "made_by": made_by(),
    });
    write_json(out.join("identify.json"), &value)?;
    let mut text = String::from(
        "time_s,place,direction,commanded_n_mm,stiffness_n_mm,stiffness_low_n_mm,stiffness_high_n_mm,\
         damping_kg_s,rmse_mm,peak_mm\n",
    );
    for i in &report.pulses {
        let (p, e) = (&i.record.pulse, &i.estimate);
        text += &format!(
            "{},{},{},{},{},{},{},{},{},{}\n",
            p.time_s,
            p.place,
            p.direction,
            i.record.commanded_n_mm,
            e.stiffness_n_mm,
            e.stiffness_interval_n_mm[0],
            e.stiffness_interval_n_mm[1],
            e.damping_kg_s,
            e.rmse_mm,
            e.peak_mm
        );
    }
    write_atomic(out.join("pulses.csv"), text.as_bytes())?;
    write_atomic(out.join("report.html"), identification_report(report).as_bytes())?;
    let configuration = json!({
        "model": arguments.model.model,
        "schedule": format!("{:?}", arguments.schedule).to_lowercase(),
        "data": arguments.data,
        "recordings": arguments.recordings,
        "pulse_force_n": arguments.pulse_force,
        "window_ms": arguments.window,
        "repeats": arguments.repeats,
    });
    run_record::write(out, "identify", global.seed, &configuration)?;
    console.json(&value);
    console.text(levels(&report.pulses, &report.on_model));
    for (name, rows) in &report.tables {
        console.text(format!("\n{name}"));
        let mut cells = vec![HEADERS.map(str::to_owned).to_vec()];
        for r in rows {
            cells.push(vec![
                number(r.nominal_n_mm, 0),
                number(r.at_rest_n_mm[0], 2),
                number(r.at_speed_n_mm[0], 2),
                number(r.delta_percent, 2),
                r.test.map_or("–".into(), |t| format!("{:.2e}", t.p)),
                number(r.change_n_mm(), 2),
                r.on_model_n_mm.map_or("–".into(), |[rest, speed]| number(speed - rest, 2)),
            ]);
        }
        console.text(table(&cells));
    }
    console.text(format!("\nreport: {}", out.join("report.html").display()));
    Ok(ExitCode::SUCCESS)
}

/// Columns of a comparison on the screen.
const HEADERS: [&str; 7] =
    ["nominal", "K at rest", "K at speed", "Δ (%)", "p", "speed − rest", "on the model"];

/// Mean stiffness and peak of each commanded level; `on_model` are the same pulses on the model itself.
fn levels(pulses: &[Identified], on_model: &[Identified]) -> String {
    let mut commanded: Vec<f64> = pulses.iter().map(|i| i.record.commanded_n_mm).collect();
    commanded.sort_by(f64::total_cmp);
    commanded.dedup_by(|a, b| a.total_cmp(b).is_eq());
    let mut rows = vec![
        ["commanded (N/mm)", "K (N/mm)", "±", "on the model", "B (kg/s)", "peak (mm)", "pulses"]
            .map(str::to_owned)
            .to_vec(),
    ];
    for level in commanded {
        let of: Vec<&Identified> =
            pulses.iter().filter(|i| i.record.commanded_n_mm.total_cmp(&level).is_eq()).collect();
        let values = |f: fn(&Identified) -> f64| of.iter().map(|i| f(i)).collect::<Vec<_>>();
        let k = values(|i| i.estimate.stiffness_n_mm);
        let twin: Vec<f64> = on_model
            .iter()
            .filter(|i| i.record.commanded_n_mm.total_cmp(&level).is_eq())
            .map(|i| i.estimate.stiffness_n_mm)
            .collect();
        rows.push(vec![
            number(level, 1),
            number(mean(&k), 1),
            number(standard_deviation(&k), 1),
            if twin.is_empty() { "–".into() } else { number(mean(&twin), 1) },
            number(mean(&values(|i| i.estimate.damping_kg_s)), 0),
            number(mean(&values(|i| i.estimate.peak_mm)), 3),
            of.len().to_string(),
        ]);
    }
    table(&rows)
}
