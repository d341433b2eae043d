//! `pam compare`.

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::{Console, table};
use crate::error::CliError;
use crate::interrupt::stop_flag;
use crate::options::{DataOptions, built_in_spring_damper};
use crate::output::Output;
use crate::run_record::{self, made_by, write_json};
use clap::Args;
use pam_baselines::comparison::files::{seconds, summary_text};
use pam_baselines::comparison::{Comparison, ComparisonConfig, Event, ModelCache, compare, split};
use pam_data::MuscleSurfaces;
use pam_data::atomic::write_atomic;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;

/// Arguments of `pam compare`.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// Configuration: recordings, split, models (docs/compare.md; `--print` shows one)
    #[arg(value_name = "CONFIG.toml", required_unless_present = "print")]
    pub config: Option<PathBuf>,
    /// Folder for comparison.json, times.json, table.csv, recordings.csv, table.tex, report.html, run.json
    /// and models/
    #[arg(long, value_name = "DIR", required_unless_present = "print")]
    pub out: Option<PathBuf>,
    /// Take over models that an earlier run of the same program into the same folder finished with the same
    /// data, settings and seed
    #[arg(long)]
    pub resume: bool,
    /// Print a configuration with every kind of model and its default settings, and exit
    #[arg(long)]
    pub print: bool,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
}

impl RunCommand for CompareArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        self.out
            .as_deref()
            .filter(|_| !self.print)
            .map(|path| Output::Folder("compare", path))
            .into_iter()
            .collect()
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        if self.print {
            console.text(ComparisonConfig::example().trim_end());
            return Ok(ExitCode::SUCCESS);
        }
        let (Some(path), Some(out)) = (&self.config, &self.out) else {
            return Err(CliError::Usage("give CONFIG.toml and --out DIR".into()));
        };
        let config = ComparisonConfig::open(path)?;
        let surfaces = config.data.surfaces.as_deref().map(MuscleSurfaces::read).transpose()?;
        // Masses for models without a gas law of their own; the others find theirs.
        let model = built_in_spring_damper(global.rig_for(&config.data.recordings)?.as_ref());
        let subjects = self.reading.subjects(&config.data.recordings, &model, global, console)?;
        let sets = split(&config, subjects)?;
        console.text(format!(
            "{}: {} models, {} recordings to fit to, {} held out.",
            config.name,
            config.models.len(),
            sets.train.len(),
            sets.held_out.len()
        ));
        run_record::write(
            out,
            "compare",
            global.seed,
            &json!({ "comparison": config, "reading": self.reading.to_json(global)? }),
        )?;

        let stop = stop_flag();
        let bar = console.progress(1000, "comparing");
        let event = |event: Event<'_>| {
            match event {
                Event::Fitting(name, share) => {
                    bar.set_message(format!("fitting {name}"));
                    bar.set_position((1000.0 * share) as u64);
                }
                Event::Predicting(name, share) => {
                    bar.set_message(format!("predicting, {name}"));
                    bar.set_position((1000.0 * share) as u64);
                }
                Event::Done(m) => bar.suspend(|| {
                    console.text(format!(
                        "  {}: R² of x held out {}, fitted in {} s",
                        m.result.name,
                        summary_text(&m.result.cold.held_out.displacement),
                        seconds(m.times.fit_s)
                    ));
                }),
                Event::Kept(name) => bar.suspend(|| console.text(format!("  {name}: was done"))),
            }
            !stop.load(Ordering::Relaxed)
        };
        let program = made_by();
        let cache = Some(ModelCache { folder: out, resume: self.resume, program: &program });
        let compared = compare(&config, &sets, surfaces.as_ref(), global.seed, cache, &event);
        bar.finish_and_clear();
        let comparison = match compared {
            Err(pam_baselines::BaselineError::Interrupted) => {
                console.text(format!("interrupted; go on with --resume --out {}", out.display()));
                return Ok(ExitCode::from(crate::INTERRUPTED));
            }
            other => other?,
        };
        write_files(&comparison, out)?;
        console
            .json(&json!({ "comparison": comparison.to_json(), "times": comparison.times_json() }));
        console.text(format!(
            "\n{}\n\ntable: {}\nreport: {}",
            table(&rows(&comparison)),
            out.join("table.csv").display(),
            out.join("report.html").display()
        ));
        Ok(ExitCode::SUCCESS)
    }
}

fn write_files(comparison: &Comparison, out: &Path) -> Result<(), CliError> {
    write_json(out.join("comparison.json"), &comparison.to_json())?;
    write_json(out.join("times.json"), &comparison.times_json())?;
    write_atomic(out.join("table.csv"), comparison.to_csv().as_bytes())?;
    write_atomic(out.join("recordings.csv"), comparison.recordings_csv().as_bytes())?;
    write_atomic(out.join("table.tex"), comparison.to_latex().as_bytes())?;
    write_atomic(out.join("report.html"), comparison.report(&made_by()).as_bytes())?;
    Ok(())
}

fn rows(comparison: &Comparison) -> Vec<Vec<String>> {
    let head =
        ["R² of x", "train, cold", "held out, cold", "train, warm", "held out, warm", "fit (s)"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    rows.extend(comparison.models.iter().map(|m| {
        let r = &m.result;
        let sets = [&r.cold.train, &r.cold.held_out, &r.warm.train, &r.warm.held_out];
        let scores = sets.iter().map(|s| summary_text(&s.displacement));
        let mut row = vec![r.name.clone()];
        row.extend(scores);
        row.push(seconds(m.times.fit_s));
        row
    }));
    rows
}
