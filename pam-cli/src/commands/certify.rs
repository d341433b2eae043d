//! `pam certify`.

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::Console;
use crate::error::{CliError, usage};
use crate::interrupt::stop_flag;
use crate::options::{DataOptions, DiagnosisOptions, ModelOptions, describe_model, given_values};
use crate::output::Output;
use crate::run_record::{self, made_by, write_json};
use crate::{INTERRUPTED, PARTIAL};
use clap::Args;
use pam_ablate::run::Shard;
use pam_data::atomic::write_atomic;
use pam_data::fingerprint::fingerprint_of_subjects;
use pam_effects::ExtendedModel;
use pam_experiment::certify::{
    CertifyFolder, CertifyOptions, Progress, Summary, Work, certificate_report, plan, run_cases,
    settings_file, with_baseline,
};
use pam_experiment::detect::DetectOptions;
use pam_experiment::plan::Synthesis;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `pam certify`.
#[derive(Debug, Args)]
pub struct CertifyArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// Baseline recordings, or folders of them, in which nothing is wrong
    #[arg(long, required = true, num_args = 1.., value_name = "PATH")]
    pub data: Vec<PathBuf>,
    /// Effects that are hidden, separated by commas, with values that are kept: `creep:time_constant_s=2;…` [default: all]
    #[arg(long, value_delimiter = ',', value_name = "ID[:NAME=VALUE;…],…")]
    pub effects: Vec<String>,
    /// Magnitudes, in multiples of the limit from which an effect is named (`pam detect`)
    #[arg(long, value_delimiter = ',', default_value = "1.5,3", value_name = "F,…")]
    pub magnitudes: Vec<f64>,
    /// Sets of recordings for each effect and magnitude
    #[arg(long, default_value_t = 5, value_name = "N")]
    pub repeats: usize,
    /// Null sets, without an effect
    #[arg(long, default_value_t = 60, value_name = "N")]
    pub nulls: usize,
    /// Rate of false alarms that the certified settings hold
    #[arg(long, default_value_t = 0.05, value_name = "P")]
    pub level: f64,
    /// Run the cases of one of n shards: 3/8. All shards write into the same folder
    #[arg(long, value_name = "I/N", value_parser = Shard::parse, default_value = "1/1")]
    pub shard: Shard,
    /// Cases at a time, each with one thread [default: as many as threads]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// The diagnosis that is certified.
    #[command(flatten)]
    pub diagnosis: DiagnosisOptions,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
    /// Folder of the cases, certificate.json, certified.toml and report.html. A stopped or killed run resumes there
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

impl CertifyArguments {
    fn options(&self, global: &GlobalOptions) -> Result<CertifyOptions, CliError> {
        if self.magnitudes.iter().any(|m| !(m.is_finite() && *m > 0.0)) {
            return Err(usage("--magnitudes: give positive multiples like 1.5,3"));
        }
        if !(self.level > 0.0 && self.level < 1.0) {
            return Err(usage(format!("--level {}: it must be between 0 and 1", self.level)));
        }
        let effects = given_values(&self.effects)?;
        Ok(CertifyOptions {
            detect: DetectOptions {
                diagnosis: self.diagnosis.diagnosis(global)?,
                effects,
                ..DetectOptions::default()
            },
            multiples: self.magnitudes.clone(),
            repeats: self.repeats,
            nulls: self.nulls,
            level: self.level,
            seed: global.seed,
        })
    }
}

impl RunCommand for CertifyArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::SharedFolder("certify", &self.out)]
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let mut options = self.options(global)?;
        let saved = self.model.load_extended(global.rig_for(&self.data)?.as_ref())?;
        let model = ExtendedModel::from_saved(saved.clone())?;
        let baseline = self.reading.subjects(&self.data, &saved, global, console)?;
        console.text("Diagnosing the baseline recordings.");
        options.detect.diagnosis = with_baseline(&model, &baseline, &options.detect.diagnosis)?;
        console.text("Foretelling the limits of the effects.");
        let (cases, detection) = plan(&model, &baseline, &options)?;
        let folder = CertifyFolder::at(&self.out);
        let inputs = json!({
            "model": saved.info.name,
            "recordings": fingerprint_of_subjects(&baseline),
            "diagnosis": DiagnosisOptions::to_json(&options.detect.diagnosis),
        });
        folder.begin(&cases, &inputs)?;
        write_json(self.out.join("detect.json"), &json!(detection))?;
        let configuration = json!({
            "model": self.model.model,
            "data": self.data,
            "effects": self.effects,
            "magnitudes": self.magnitudes,
            "repeats": self.repeats,
            "nulls": self.nulls,
            "level": self.level,
            "diagnosis": DiagnosisOptions::to_json(&options.detect.diagnosis),
            "reading": self.reading.to_json(global)?,
        });
        run_record::write(&self.out, "certify", global.seed, &configuration)?;
        let synthesis = Synthesis::new(&model, &baseline, &options.detect.diagnosis)?;
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let jobs = self.jobs.map_or(global.threads.unwrap_or(threads), usize::from);
        let bar = console.progress(cases.cases.len(), "cases");
        let progress = |p: Progress<'_>| match p {
            Progress::Planned(due, over) => {
                bar.set_length(due as u64);
                console.text(format!("{due} cases to run, {over} were done before."));
            }
            Progress::Over(outcome) => {
                bar.set_message(outcome.case.id.clone());
                bar.inc(1);
            }
        };
        let own = |index: usize| self.shard.has(index);
        let stop = stop_flag();
        let work = Work {
            model: &model,
            baseline: &baseline,
            synthesis: &synthesis,
            plan: &cases,
            diagnosis: &options.detect.diagnosis,
            folder: &folder,
        };
        let finished = run_cases(&work, &own, jobs, stop, &progress)?;
        bar.finish_and_clear();
        let outcomes = folder.outcomes(&cases)?;
        let mut summary = Summary::of(&cases, &outcomes, &options, &made_by());
        let absolute = |p: &PathBuf| std::path::absolute(p).unwrap_or_else(|_| p.clone());
        summary.certificate.baseline = self.data.iter().map(absolute).collect();
        write_json(self.out.join("certificate.json"), &json!(summary))?;
        let file = settings_file(&summary, &options.detect.diagnosis.settings);
        write_atomic(self.out.join("certified.toml"), file.as_bytes())?;
        let report = certificate_report(&summary, &describe_model(&saved), &made_by());
        write_atomic(self.out.join("report.html"), report.as_bytes())?;
        console.json(&json!(summary));
        let [over, all] = summary.cases;
        console.text(format!(
            "{over} of {all} cases are over, {} without a diagnosis; {:.1} s each.\n{}\nsettings: {}\nreport: {}",
            summary.refused,
            summary.mean_wall_s,
            summary.certificate.sentence(summary.log_odds),
            self.out.join("certified.toml").display(),
            self.out.join("report.html").display()
        ));
        if !finished {
            console.text("interrupted; the same command goes on with it");
            return Ok(ExitCode::from(INTERRUPTED));
        }
        let whole = over == all && summary.refused == 0;
        Ok(if whole { ExitCode::SUCCESS } else { ExitCode::from(PARTIAL) })
    }
}
