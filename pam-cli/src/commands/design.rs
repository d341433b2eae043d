//! `pam design`.

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::{Console, table};
use crate::error::{CliError, failed, usage};
use crate::options::{DiagnosisOptions, ModelOptions, describe_model, given_values};
use crate::output::Output;
use crate::run_record::{self, made_by, write_json};
use clap::{Args, ValueEnum};
use pam_core::units::significant;
use pam_data::atomic::write_atomic;
use pam_data::toml_file;
use pam_effects::ExtendedModel;
use pam_effects::effects::AnyEffect;
use pam_experiment::design::{
    Design, DesignLimits, DesignOptions, LiveCause, Objective, commands_csv, design, design_report,
};
use pam_experiment::detect::DetectOptions;
use pam_rig::{Protocol, RigParameters};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Which of the detection limits a design lowers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LimitChoice {
    /// The median of the detection limits
    Median,
    /// The worst of them
    Worst,
}

/// Limits and effort of a design.
#[derive(Debug, Clone, Args)]
pub struct DesignEffort {
    /// Rig whose motor and sensors count: default, measured, or a TOML file
    #[arg(long = "design-rig", alias = "rig", value_name = "NAME|FILE", default_value = "default")]
    pub rig: String,
    /// Length of each recording of the design
    #[arg(long, default_value_t = 20.0, value_name = "S")]
    pub seconds: f64,
    /// Recordings of the design, each with sealed pressures of its own
    #[arg(long, default_value_t = 3, value_name = "N")]
    pub recordings: usize,
    /// Largest current of the design
    #[arg(long, default_value_t = 1.5, value_name = "A")]
    pub current_a: f64,
    /// Least and greatest sealed pressure of the design, psi gauge: where the model is accurate
    #[arg(
        long,
        value_delimiter = ',',
        num_args = 2,
        default_value = "10,80",
        value_name = "LOW,HIGH"
    )]
    pub psi: Vec<u8>,
    /// Largest displacement of the joint under the design
    #[arg(long, default_value_t = 5.0, value_name = "MM")]
    pub travel_mm: f64,
    /// Largest speed of the joint under the design: a learned force is known where it was trained [default: none]
    #[arg(long, default_value_t = f64::INFINITY, hide_default_value = true, value_name = "MM_S")]
    pub speed_mm_s: f64,
    /// Longest time with one current: rest shows friction and creep that a model of the moving joint lacks [default: none]
    #[arg(long, default_value_t = f64::INFINITY, hide_default_value = true, value_name = "S")]
    pub hold_s: f64,
    /// Protocols that are simulated
    #[arg(long, default_value_t = 1200, value_name = "N")]
    pub evaluations: usize,
}

impl DesignEffort {
    /// The limits and the sensors.
    ///
    /// # Errors
    /// [`CliError`] naming the option that is out of range.
    pub fn options(&self, detect: DetectOptions, seed: u64) -> Result<DesignOptions, CliError> {
        let rig = RigParameters::open(&self.rig)?;
        let within = |name: &str, value: f64, low: f64, high: f64| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(usage(format!("{name} {value}: it must be from {low} to {high}")))
        };
        within("--seconds", self.seconds, 3.0, 3600.0)?;
        within("--recordings", self.recordings as f64, 1.0, 64.0)?;
        within("--current-a", self.current_a, 1e-3, Protocol::LARGEST_A)?;
        within("--travel-mm", self.travel_mm, 1e-3, 50.0)?;
        within("--hold-s", self.hold_s, 0.1, f64::INFINITY)?;
        within("--speed-mm-s", self.speed_mm_s, 1e-3, f64::INFINITY)?;
        let psi = match self.psi[..] {
            [low, high] if low < high && high <= Protocol::LARGEST_PSI => [low, high],
            _ => {
                let most = Protocol::LARGEST_PSI;
                return Err(usage(format!("--psi: give two pressures in order, at most {most}")));
            }
        };
        Ok(DesignOptions {
            detect,
            limits: DesignLimits {
                current_a: self.current_a,
                psi,
                travel_mm: self.travel_mm,
                speed_mm_s: self.speed_mm_s,
                hold_s: self.hold_s,
                recordings: self.recordings,
                seconds: self.seconds,
                ..DesignLimits::default()
            },
            sensors: rig.sensors,
            evaluations: self.evaluations,
            seed,
            ..DesignOptions::default()
        })
    }
}

/// Arguments of `pam design`.
#[derive(Debug, Args)]
pub struct DesignArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// Folder of a diagnosis (`pam diagnose --out`): the design distinguishes its live causes
    #[arg(long, value_name = "DIR")]
    pub diagnosis_of: Option<PathBuf>,
    /// Without a diagnosis: which detection limits the design lowers
    #[arg(long, value_enum, default_value_t = LimitChoice::Median, value_name = "WHICH")]
    pub lower: LimitChoice,
    /// Effects whose limits count, separated by commas [default: all]
    #[arg(long, value_delimiter = ',', value_name = "ID[:NAME=VALUE;…],…")]
    pub effects: Vec<String>,
    /// Limits and effort.
    #[command(flatten)]
    pub effort: DesignEffort,
    /// The diagnosis that is foretold.
    #[command(flatten)]
    pub diagnosis: DiagnosisOptions,
    /// Folder for design.toml, design.json, report.html and the commands of each recording as CSV
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

impl RunCommand for DesignArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::Folder("design", &self.out)]
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let effects = given_values(&self.effects)?;
        let detect = DetectOptions {
            diagnosis: self.diagnosis.diagnosis(global)?,
            effects,
            ..DetectOptions::default()
        };
        let mut options = self.effort.options(detect, global.seed)?;
        options.objective = match (&self.diagnosis_of, self.lower) {
            (Some(folder), _) => {
                let candidates = &options.detect.diagnosis.candidates;
                Objective::Separation(live_causes(folder, candidates)?)
            }
            (None, LimitChoice::Median) => Objective::MedianLimit,
            (None, LimitChoice::Worst) => Objective::WorstLimit,
        };
        let saved = self.model.load_extended(global.rig()?.as_ref())?;
        let model = ExtendedModel::from_saved(saved.clone())?;
        let designed = design_into(
            &self.out,
            &model,
            &describe_model(&saved),
            &options,
            "report.html",
            console,
        )?;
        let configuration = json!({
            "model": self.model.model,
            "diagnosis": self.diagnosis_of,
            "lower": format!("{:?}", self.lower).to_lowercase(),
            "effects": self.effects,
            "rig": self.effort.rig,
            "seconds": self.effort.seconds,
            "recordings": self.effort.recordings,
            "current_a": self.effort.current_a,
            "psi": self.effort.psi,
            "travel_mm": self.effort.travel_mm,
            "speed_mm_s": self.effort.speed_mm_s,
            "hold_s": self.effort.hold_s,
            "evaluations": self.effort.evaluations,
            "settings": options.detect.diagnosis.settings,
        });
        run_record::write(&self.out, "design", global.seed, &configuration)?;
        console.json(&json!(designed));
        Ok(ExitCode::SUCCESS)
    }
}

/// Designs a protocol and writes `design.toml`, `design.json`, a page of the given name, and the commands as CSV.
///
/// # Errors
/// [`CliError`] if the model cannot be simulated or a file cannot be written.
pub fn design_into(
    folder: impl AsRef<Path>,
    model: &ExtendedModel,
    model_line: &str,
    options: &DesignOptions,
    page: &str,
    console: &Console,
) -> Result<Design, CliError> {
    let folder = folder.as_ref();
    let bar = console.progress(1000, "trying protocols");
    let designed = design(model, options, &|share| bar.set_position((1000.0 * share) as u64))?;
    bar.finish_and_clear();
    write_atomic(folder.join("design.toml"), designed.protocol.to_toml().as_bytes())?;
    write_json(folder.join("design.json"), &json!(designed))?;
    let motor = &options.sensors.motor;
    let rate_hz = options.sensors.clock.rate_hz;
    for (name, text) in commands_csv(&designed.protocol, motor, rate_hz, options.seed)? {
        write_atomic(folder.join("commands").join(format!("{name}.csv")), text.as_bytes())?;
    }
    let report = design_report(&designed, model_line, &made_by());
    let page = folder.join(page);
    write_atomic(&page, report.as_bytes())?;
    console.text(gains_table(&designed));
    console.text(format!(
        "\n{}\nprotocol: {}\nreport: {}",
        designed.sentence(),
        folder.join("design.toml").display(),
        page.display()
    ));
    Ok(designed)
}

fn gains_table(designed: &Design) -> String {
    let n = |v: f64| significant(v, 3);
    let mut rows = Vec::new();
    if designed.separations.is_empty() {
        let head = ["effect", "parameter", "published", "designed", "factor"];
        rows.push(head.map(str::to_owned).to_vec());
        for g in &designed.gains {
            let cell = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), n);
            rows.push(vec![
                g.label.clone(),
                g.parameter.clone(),
                cell(g.standard),
                cell(g.designed),
                cell(g.factor),
            ]);
        }
    } else {
        let head = ["cause", "other", "published", "designed"];
        rows.push(head.map(str::to_owned).to_vec());
        for s in &designed.separations {
            let own = [s.standard, s.designed].map(n);
            rows.push([vec![s.cause.clone(), s.other.clone()], own.to_vec()].concat());
        }
    }
    table(&rows)
}

/// The named causes of a diagnosis with what it does not distinguish from them.
fn live_causes(
    folder: &Path,
    candidates: &[&'static dyn AnyEffect],
) -> Result<Vec<LiveCause>, CliError> {
    let path = folder.join("diagnosis.json");
    let text = toml_file::text(&path)?;
    let fail = |message: &str| failed(format!("{}: {message}", path.display()));
    let json: Value = serde_json::from_str(&text).map_err(|e| fail(&e.to_string()))?;
    let place = |id: &str| candidates.iter().position(|e| e.info().id == id);
    let values = |id: &str, parameters: &Value| -> Option<(usize, Vec<f64>)> {
        let candidate = place(id)?;
        let info = candidates[candidate].info();
        let value = |name: &str| {
            let own = &parameters[name];
            own["value"].as_f64().or_else(|| own.as_f64()).unwrap_or(0.0)
        };
        Some((candidate, info.value_names().map(value).collect()))
    };
    let mut live = Vec::new();
    for cause in json["causes"].as_array().into_iter().flatten() {
        let Some(id) = cause["effect"].as_str() else { continue };
        let others: Vec<(usize, Vec<f64>)> = cause["alternatives"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(|o| values(o["effect"].as_str()?, &o["values"]))
            .collect();
        if let Some(own) = values(id, &cause["parameters"])
            && !others.is_empty()
        {
            live.push(LiveCause { cause: own, others });
        }
    }
    if live.is_empty() {
        return Err(fail(
            "no named cause is confusable with another one: there is nothing to separate",
        ));
    }
    Ok(live)
}
