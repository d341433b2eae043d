//! `pam simulate`.

use super::RunCommand;
use super::convert::{numbered, recording_writer};
use crate::PARTIAL;
use crate::arguments::GlobalOptions;
use crate::console::Console;
use crate::error::{CliError, failed, usage};
use crate::options::{DataOptions, ModelOptions, SolverOptions, describe_model};
use crate::output::Output;
use crate::run_record::made_by;
use clap::Args;
use pam_core::SealedMasses;
use pam_core::units::MN_PER_N;
use pam_data::atomic::write_atomic;
use pam_data::{MassOrigin, Recording, SavedModel, Subject};
use pam_effects::{ActiveEffect, EffectError, EffectRecord, ExtendedModel};
use pam_report::simulation_report;
use pam_solvers::Statistics;
use pam_trajectory::{Predictor, SolverSettings};
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `pam simulate`.
#[derive(Debug, Args)]
pub struct SimulateArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// Recording whose measured force drives the joint, from its first sample
    #[arg(long, value_name = "PATH", conflicts_with_all = ["force", "pressures", "air_masses", "duration"])]
    pub data: Option<PathBuf>,
    /// Synthetic force on the joint at rest: constant:A=N, step:A=N,t=S, sine:A=N,f=HZ or
    /// chirp:A=N,f0=HZ,f1=HZ (A in N)
    #[arg(long, value_name = "SPEC", required_unless_present = "data")]
    pub force: Option<String>,
    /// Duration of a synthetic run, s
    #[arg(long, value_name = "S", default_value_t = 10.0, allow_negative_numbers = true)]
    pub duration: f64,
    /// Samples per second of a synthetic run
    #[arg(long, value_name = "HZ", default_value_t = 1000.0, allow_negative_numbers = true)]
    pub rate: f64,
    /// Sealed pressures of flexor and extensor at x = 0, kPa absolute [default: 412,412]
    #[arg(
        long,
        value_name = "PF,PE",
        value_delimiter = ',',
        num_args = 1,
        allow_hyphen_values = true,
        conflicts_with = "air_masses"
    )]
    pub pressures: Option<Vec<f64>>,
    /// Sealed air masses of flexor and extensor, g
    #[arg(
        long,
        value_name = "MF,ME",
        value_delimiter = ',',
        num_args = 1,
        allow_hyphen_values = true
    )]
    pub air_masses: Option<Vec<f64>>,
    /// Effect that is added to the model, as in coulomb_friction:force_n=12; may be given several times (`pam parts` lists
    /// them)
    #[arg(long = "effect", value_name = "ID:NAME=VALUE,…")]
    pub effects: Vec<String>,
    /// File for the trajectory: .csv or .npz
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Also write a report with figures
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
    /// How the equations are solved.
    #[command(flatten)]
    pub solver: SolverOptions,
}

/// Sealed pressures of a synthetic run if none are given, kPa absolute (45 psi gauge).
const DEFAULT_PRESSURE_KPA: f64 = 412.0;

impl RunCommand for SimulateArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        [Some(&self.out), self.report.as_ref()]
            .into_iter()
            .flatten()
            .map(|p| Output::File(p))
            .collect()
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let write = recording_writer(&self.out)?;
        let mut saved = self.model.load_extended(global.rig_for(self.data.as_slice())?.as_ref())?;
        for text in &self.effects {
            saved.info.effects.push(json!(added_effect(text)?));
        }
        let settings = self.solver.settings_for(&saved)?;
        let subjects = match &self.data {
            Some(path) => {
                self.reading.subjects(std::slice::from_ref(path), &saved, global, console)?
            }
            None => vec![made_up(self, &saved)?],
        };
        // A recording with gaps falls into parts, which become numbered files.
        let parts = subjects.len();
        let path_of = |path: &Path, i: usize| {
            if parts == 1 { path.to_owned() } else { numbered(path, i + 1) }
        };
        let mut runs = Vec::new();
        let mut stopped = false;
        for (i, subject) in subjects.iter().enumerate() {
            let run = Run::of(&saved, subject, &settings)?;
            let out = path_of(&self.out, i);
            write(&out, &run.trajectory)?;
            if let Some(path) = &self.report {
                let text = report(&run, &saved, &settings.describe());
                write_atomic(path_of(path, i), text.as_bytes())?;
            }
            console.text(run.summary(&out));
            if let Some(why) = &run.failure {
                console.warn(format!("stopped early, what was reached is written: {why}"));
                stopped = true;
            }
            runs.push(run.to_json(&out));
        }
        console.json(&json!({ "runs": runs, "seed": global.seed }));
        Ok(if stopped { ExitCode::from(PARTIAL) } else { ExitCode::SUCCESS })
    }
}

/// The effect of `--effect`.
pub(super) fn added_effect(text: &str) -> Result<ActiveEffect, CliError> {
    let wrong = |e: EffectError| usage(format!("--effect {text}: {e}"));
    text.parse::<EffectRecord>().and_then(|record| record.resolve(&[])).map_err(wrong)
}

/// One simulated trajectory.
struct Run {
    trajectory: Recording,
    statistics: Statistics,
    masses: SealedMasses,
    failure: Option<String>,
}

impl Run {
    /// Simulates; a run that stops early keeps what it reached.
    fn of(
        saved: &SavedModel,
        subject: &Subject,
        settings: &SolverSettings,
    ) -> Result<Self, CliError> {
        let (prediction, failure) = match ExtendedModel::from_saved(saved.clone())?.predict(
            &subject.recording,
            subject.masses,
            settings,
        ) {
            Ok(prediction) => (prediction, None),
            Err(e) => (e.partial, Some(e.why)),
        };
        if prediction.is_empty() {
            return Err(failed(failure.unwrap_or_else(|| "nothing was simulated".into())));
        }
        Ok(Self {
            trajectory: prediction.to_recording(&subject.recording, subject.masses),
            statistics: prediction.statistics,
            masses: subject.masses,
            failure,
        })
    }

    fn x_range_mm(&self) -> (f64, f64) {
        let x = self.trajectory.displacement_mm.iter().copied();
        (x.clone().fold(f64::INFINITY, f64::min), x.fold(f64::NEG_INFINITY, f64::max))
    }

    fn summary(&self, out: &Path) -> String {
        let (low, high) = self.x_range_mm();
        format!(
            "{} samples, x from {low:.4} to {high:.4} mm, {} steps, {} field evaluations -> {}",
            self.trajectory.len(),
            self.statistics.accepted,
            self.statistics.evaluations,
            out.display()
        )
    }

    fn to_json(&self, out: &Path) -> Value {
        let (low, high) = self.x_range_mm();
        json!({
            "out": out,
            "samples": self.trajectory.len(),
            "mass_flexor_g": self.masses.flexor_g,
            "mass_extensor_g": self.masses.extensor_g,
            "x_min_mm": low,
            "x_max_mm": high,
            "accepted_steps": self.statistics.accepted,
            "rejected_steps": self.statistics.rejected,
            "field_evaluations": self.statistics.evaluations,
            "failure": self.failure,
        })
    }
}

/// A run of the joint at rest at x = 0 under a synthetic force.
fn made_up(arguments: &SimulateArguments, saved: &SavedModel) -> Result<Subject, CliError> {
    let spec = arguments.force.as_deref().unwrap_or_default();
    let (duration, rate) = (arguments.duration, arguments.rate);
    let samples = duration * rate;
    if !(samples.is_finite() && duration > 0.0 && (1.0..1e8).contains(&samples)) {
        return Err(CliError::Usage(format!(
            "--duration {duration} s at --rate {rate} Hz is no run: both must be positive and make at \
             least one step"
        )));
    }
    let masses = match (&arguments.air_masses, &arguments.pressures) {
        (Some(m), _) => {
            let [f, e] = pair("--air-masses", m)?;
            SealedMasses::new(f, e).map_err(usage)?
        }
        (None, pressures) => {
            let p = match pressures {
                Some(p) => pair("--pressures", p)?,
                None => [DEFAULT_PRESSURE_KPA; 2],
            };
            let m = saved.model.gas_law_masses(0.0, p);
            SealedMasses::new(m.flexor_g, m.extensor_g).map_err(usage)?
        }
    };
    let [pf, pe] = saved.model.gas_law_pressures_kpa(0.0, masses);
    let n = samples.round() as usize + 1;
    let force = parse_force(spec, duration)?;
    let mut recording = Recording::empty(&arguments.out);
    recording.time_s = (0..n).map(|k| k as f64 / rate).collect();
    recording.force_mn = recording.time_s.iter().map(|&t| MN_PER_N * force(t)).collect();
    recording.displacement_mm = vec![0.0; n];
    recording.velocity_mm_s = vec![0.0; n];
    recording.pressure_flexor_kpa = vec![pf; n];
    recording.pressure_extensor_kpa = vec![pe; n];
    Ok(Subject { recording, masses, origin: MassOrigin::Given })
}

fn pair(option: &str, values: &[f64]) -> Result<[f64; 2], CliError> {
    <[f64; 2]>::try_from(values)
        .map_err(|_| CliError::Usage(format!("{option} takes two numbers, flexor,extensor")))
}

/// A force (N) over time (s) from its description, for example `sine:A=120,f=0.5`.
fn parse_force(spec: &str, duration: f64) -> Result<Box<dyn Fn(f64) -> f64>, CliError> {
    let wrong = |why: String| CliError::Usage(format!("--force {spec}: {why}"));
    let (kind, rest) = spec.split_once(':').unwrap_or((spec, ""));
    let mut values = std::collections::BTreeMap::new();
    for part in rest.split(',').filter(|p| !p.is_empty()) {
        let (key, value) =
            part.split_once('=').ok_or_else(|| wrong(format!("`{part}` is not key=value")))?;
        let number: f64 =
            value.trim().parse().map_err(|_| wrong(format!("`{value}` is not a number")))?;
        if !number.is_finite() {
            return Err(wrong(format!("{key} is not finite")));
        }
        values.insert(key.trim(), number);
    }
    let mut take =
        |key: &str| values.remove(key).ok_or_else(|| wrong(format!("`{key}` is missing")));
    let force: Box<dyn Fn(f64) -> f64> = match kind {
        "constant" => {
            let a = take("A")?;
            Box::new(move |_| a)
        }
        "step" => {
            let (a, start) = (take("A")?, take("t")?);
            Box::new(move |t| if t >= start { a } else { 0.0 })
        }
        "sine" => {
            let (a, f) = (take("A")?, take("f")?);
            Box::new(move |t| a * (TAU * f * t).sin())
        }
        "chirp" => {
            let (a, f0, f1) = (take("A")?, take("f0")?, take("f1")?);
            Box::new(move |t| a * (TAU * (f0 + 0.5 * (f1 - f0) * t / duration) * t).sin())
        }
        _ => return Err(wrong("known are constant, step, sine and chirp".into())),
    };
    if let Some(key) = values.keys().next() {
        return Err(wrong(format!("`{key}` is not a parameter of {kind}")));
    }
    Ok(force)
}

fn report(run: &Run, saved: &SavedModel, solver: &str) -> String {
    let failure = run.failure.as_ref().map(|f| format!(" Stopped early: {f}")).unwrap_or_default();
    let title = format!("Simulation with {}", saved.info.name);
    let lead = format!("{} Solved with {solver}.{failure}", describe_model(saved));
    simulation_report(&run.trajectory, &title, &lead, &made_by())
}
