//! `pam detect`.

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::{Console, table};
use crate::error::{CliError, usage};
use crate::options::{DataOptions, DiagnosisOptions, ModelOptions, describe_model, given_values};
use crate::output::Output;
use crate::run_record::{self, made_by, write_json};
use clap::Args;
use pam_core::units::significant;
use pam_data::atomic::write_atomic;
use pam_data::{SavedModel, Subject, toml_file};
use pam_diagnose::DiagnosisSettings;
use pam_diagnose::joint::{PreparedTrials, Signatures};
use pam_diagnose::noise::Noise;
use pam_effects::ExtendedModel;
use pam_effects::simulation::ResampledRecord;
use pam_experiment::detect::{DetectOptions, Detection, Limit, detect, detection_report};
use pam_experiment::plan::{noise_from_toml, planned_runs, sensor_view};
use pam_rig::{Conditions, Protocol, RigParameters};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// A protocol with its conditions and its length.
#[derive(Debug, Clone, Args)]
pub struct ProtocolOptions {
    /// Protocol that would be measured: a built-in one (paper, validation, pulses) or a TOML file
    #[arg(long, value_name = "NAME|FILE")]
    pub protocol: Option<String>,
    /// Sealed pressures instead of the protocol's: train, grid, symmetric, or pairs of psi gauge like 30/60,45/45
    #[arg(long, value_name = "SET|PAIRS")]
    pub conditions: Option<String>,
    /// Length of each recording: the segments of the protocol are stretched to it
    #[arg(long, value_name = "S")]
    pub seconds: Option<f64>,
    /// Rig whose motor and sensors the recordings would have: default, measured, or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub rig: String,
}

impl ProtocolOptions {
    /// The protocol, `name` if none is given.
    ///
    /// # Errors
    /// [`CliError`] naming the file or the option.
    pub fn protocol(&self, name: &str) -> Result<Protocol, CliError> {
        let mut protocol = Protocol::open(self.protocol.as_deref().unwrap_or(name))?;
        if let Some(text) = &self.conditions {
            let conditions = Conditions::parse(text);
            protocol.conditions =
                Some(conditions.map_err(|why| CliError::Usage(format!("--conditions: {why}")))?);
        }
        if let Some(seconds) = self.seconds {
            if !(1.0..=36_000.0).contains(&seconds) {
                return Err(usage(format!("--seconds {seconds}: give 1 s to 10 h")));
            }
            protocol = protocol.with_duration(seconds);
        }
        Ok(protocol)
    }
}

/// Arguments of `pam detect`.
#[derive(Debug, Args)]
pub struct DetectArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// What would be measured.
    #[command(flatten)]
    pub plan: ProtocolOptions,
    /// Recordings instead of a protocol: their excitation and their noise count
    #[arg(long, num_args = 1.., value_name = "PATH", conflicts_with_all = ["protocol", "conditions", "seconds"])]
    pub data: Vec<PathBuf>,
    /// Noise of the channels: a TOML file (docs/experiment.md), or recordings from whose residuals it is learned
    /// [default: the sensors of the rig, or the data]
    #[arg(long, num_args = 1.., value_name = "FILE.toml|PATH", conflicts_with = "data")]
    pub noise: Vec<PathBuf>,
    /// Effects, separated by commas, with values that are kept: `creep:time_constant_s=2;…` [default: all]
    #[arg(long, value_delimiter = ',', value_name = "ID[:NAME=VALUE;…],…")]
    pub effects: Vec<String>,
    /// Power of the limits
    #[arg(long, default_value_t = 0.9, value_name = "P")]
    pub power: f64,
    /// Familywise rate of false alarms of the limit of any test
    #[arg(long, default_value_t = 0.05, value_name = "P")]
    pub level: f64,
    /// Diagnoses of simulated recordings by which the limit of each effect is found; 0 foretells it without any
    /// [default: 8, or 0 for recordings of more than 100 s together]
    #[arg(long, value_name = "N")]
    pub trials: Option<usize>,
    /// The diagnosis that is foretold.
    #[command(flatten)]
    pub diagnosis: DiagnosisOptions,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
    /// Folder for detect.json and report.html
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Simulated recordings of a protocol.
pub(super) fn planned(
    model: &ExtendedModel,
    protocol: &Protocol,
    rig: &RigParameters,
    seed: u64,
) -> Result<Vec<Subject>, CliError> {
    let runs = planned_runs(protocol, &rig.sensors.motor, rig.sensors.clock.rate_hz, seed)?;
    Ok(runs.iter().map(|run| run.simulated(model)).collect::<Result<_, _>>()?)
}

/// The time between two rows of a diagnosis, s.
fn row_s(settings: &DiagnosisSettings) -> f64 {
    settings.data.points_per_row as f64 * ResampledRecord::STEP_S
}

impl DetectArguments {
    /// The noise that is given, from a file or from recordings.
    fn given_noise(
        &self,
        saved: &SavedModel,
        options: &DetectOptions,
        global: &GlobalOptions,
        console: &Console,
    ) -> Result<Option<Noise>, CliError> {
        match self.noise.as_slice() {
            [] => Ok(None),
            [file] if file.extension().is_some_and(|e| e == "toml") => {
                let row_s = row_s(&options.diagnosis.settings);
                Ok(Some(noise_from_toml(&toml_file::text(file)?, file, row_s)?))
            }
            paths => {
                let model = ExtendedModel::from_saved(saved.clone())?;
                let subjects = self.reading.subjects(paths, saved, global, console)?;
                let trials = PreparedTrials::new(&model, &subjects, &options.diagnosis.settings)?;
                let learned = Signatures::new(&model, &trials, &options.diagnosis, None)?;
                Ok(Some(learned.noise().common()))
            }
        }
    }
}

impl RunCommand for DetectArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::Folder("detect", &self.out)]
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        for (name, value) in [("--power", self.power), ("--level", self.level)] {
            if !(value > 0.0 && value < 1.0) {
                return Err(usage(format!("{name} {value}: it must be between 0 and 1")));
            }
        }
        let effects = given_values(&self.effects)?;
        let options = DetectOptions {
            diagnosis: self.diagnosis.diagnosis(global)?,
            effects,
            power: self.power,
            level: self.level,
            trials: self.trials,
        };
        let saved = self.model.load_extended(global.rig_for(&self.data)?.as_ref())?;
        let model = ExtendedModel::from_saved(saved.clone())?;
        let noise = self.given_noise(&saved, &options, global, console)?;
        let protocol = self.plan.protocol("paper")?;
        let (recordings, noise) = if self.data.is_empty() {
            let rig = RigParameters::open(&self.plan.rig)?;
            let recordings = planned(&model, &protocol, &rig, global.seed)?;
            let noise = match noise {
                Some(noise) => noise.into(),
                None => sensor_view(&model, &recordings, &rig.sensors, &options.diagnosis)?,
            };
            (recordings, Some(noise))
        } else {
            (self.reading.subjects(&self.data, &saved, global, console)?, None)
        };
        let bar = console.progress(1, "diagnoses of simulated recordings");
        let progress = |over: usize, all: usize| {
            bar.set_length(all as u64);
            bar.set_position(over as u64);
        };
        let detection = detect(&model, &recordings, noise.as_ref(), &options, &progress)?;
        bar.finish_and_clear();
        write_json(self.out.join("detect.json"), &json!(detection))?;
        let report = detection_report(&detection, &describe_model(&saved), &made_by());
        write_atomic(self.out.join("report.html"), report.as_bytes())?;
        let configuration = json!({
            "model": self.model.model,
            "protocol": self.data.is_empty().then_some(&protocol),
            "rig": self.plan.rig,
            "data": self.data,
            "noise": self.noise,
            "effects": self.effects,
            "power": self.power,
            "level": self.level,
            "trials": self.trials,
            "diagnosis": DiagnosisOptions::to_json(&options.diagnosis),
            "reading": self.reading.to_json(global)?,
        });
        run_record::write(&self.out, "detect", global.seed, &configuration)?;
        console.json(&json!(detection));
        console.text(limits_table(&detection));
        if detection.limits.iter().all(|l| l.tried.is_none()) {
            console.text(FORETOLD);
        }
        console.text(format!("\nreport: {}", self.out.join("report.html").display()));
        Ok(ExitCode::SUCCESS)
    }
}

/// Said where no trials were made.
const FORETOLD: &str = "\nThe limits are foretold without diagnoses and may be off by a factor of three; --trials 8 finds them by diagnoses of \
                        simulated recordings.";

/// The limits, with the nearest other effect of each.
fn limits_table(detection: &Detection) -> String {
    let head = [
        "effect",
        "parameter",
        "named from",
        "foretold",
        "listed from",
        "any test",
        "most like",
        "cosine",
    ];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    let cell = |l: Option<Limit>| l.map_or_else(|| "–".into(), |l| significant(l.value, 3));
    for l in &detection.limits {
        let near = detection.pairs.iter().filter(|p| p.effect == l.label);
        let near = near.max_by(|a, b| a.cosine.total_cmp(&b.cosine));
        rows.push(vec![
            l.label.clone(),
            l.parameter.clone(),
            cell(l.named),
            cell(l.foretold),
            cell(l.listed),
            cell(l.familywise),
            near.map_or_else(String::new, |p| p.other.clone()),
            near.map_or_else(String::new, |p| format!("{:.3}", p.cosine)),
        ]);
    }
    table(&rows)
}
