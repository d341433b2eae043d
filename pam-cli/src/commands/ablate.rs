//! `pam ablate`.

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::{Console, table};
use crate::error::CliError;
use crate::interrupt::{seconds, stop_flag};
use crate::options::DataOptions;
use crate::output::Output;
use crate::run_record::{self, made_by};
use crate::{INTERRUPTED, PARTIAL};
use clap::{Args, Subcommand};
use indicatif::ProgressBar;
use pam_ablate::prelude::*;
use pam_ablate::run::Shard;
use pam_ablate::slurm::BATCH_SCRIPT;
use pam_ablate::summary::{mean_text, short};
use pam_ablate::sweep::Sweep;
use pam_data::LoadOptions;
use serde_json::json;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Arguments of `pam ablate`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct AblateArguments {
    /// Subcommand.
    #[command(subcommand)]
    pub command: Option<AblateCommand>,
    /// Sweep.
    #[arg(value_name = "NAME|FILE", required_unless_present = "out", help = sweeps())]
    pub sweep: Option<String>,
    /// Folder of the sweep: cells, tables, report. A stopped or killed sweep resumes there
    #[arg(long, value_name = "DIR", required_unless_present_any = ["print", "list"])]
    pub out: Option<PathBuf>,
    /// Recordings, or folders of them, in place of the sweep's
    #[arg(long, num_args = 1.., value_name = "PATH")]
    pub data: Vec<PathBuf>,
    /// Set a value in all cells, before the axes: stage.2.epochs=5. Can be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Seeds of the cells, in place of the sweep's: 1,2,3
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    pub seeds: Vec<u64>,
    /// Run the cells of one of n shards: 3/8
    #[arg(long, value_name = "I/N", value_parser = Shard::parse, default_value = "1/1")]
    pub shard: Shard,
    /// After the shard's own cells, run idle cells of other shards
    #[arg(long)]
    pub steal: bool,
    /// Cells at a time, which share the threads [default: as many as threads]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Run cells that failed again
    #[arg(long)]
    pub retry_failed: bool,
    /// Replace the sweep of the folder by this one; cells that are in both are kept
    #[arg(long)]
    pub extend: bool,
    /// Seconds between checkpoints of a cell
    #[arg(long, default_value_t = 10.0, value_name = "S")]
    pub checkpoint_s: f64,
    /// List the cells with their states, and run nothing
    #[arg(long)]
    pub list: bool,
    /// Print a built-in sweep and exit
    #[arg(long, conflicts_with = "list")]
    pub print: bool,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
}

/// Help of the sweep of `pam ablate`.
fn sweeps() -> String {
    format!(
        "A sweep: {}, or a TOML file (docs/ablations.md) [default: the one that the folder of --out was begun with]",
        Sweep::BUILT_IN.join(", ")
    )
}

/// Subcommands of `pam ablate`.
#[derive(Debug, Subcommand)]
pub enum AblateCommand {
    /// Merge the cells of one or several folders of a sweep and write tables and report
    Merge(MergeArguments),
    /// Print a batch script that runs a sweep as a job array of Slurm
    Template,
}

/// Arguments of `pam ablate merge`.
#[derive(Debug, Args)]
pub struct MergeArguments {
    /// Folders of the sweep
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Folder for cells, tables and report [default: the folder, if there is only one]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

impl RunCommand for AblateArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        let out = match &self.command {
            Some(AblateCommand::Template) => None,
            Some(AblateCommand::Merge(a)) => a.out.as_deref(),
            None if self.list || self.print => None,
            None => self.out.as_deref(),
        };
        out.map(|path| Output::SharedFolder("ablate", path)).into_iter().collect()
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        match &self.command {
            Some(AblateCommand::Template) => {
                console.text(BATCH_SCRIPT.trim_end());
                console.json(&json!({ "script": BATCH_SCRIPT }));
                Ok(ExitCode::SUCCESS)
            }
            Some(AblateCommand::Merge(a)) => merged(a, console),
            None => sweep(self, global, console),
        }
    }
}

/// The sweep of the arguments, with what they override.
fn asked(arguments: &AblateArguments) -> Result<Sweep, CliError> {
    let mut sweep = match (&arguments.sweep, &arguments.out) {
        (Some(name), _) => Sweep::open(name)?,
        (None, Some(out)) => SweepFolder::at(out).sweep()?,
        (None, None) => return Err(CliError::Usage("give a sweep, or --out of one".into())),
    };
    for text in &arguments.overrides {
        sweep.override_with(text)?;
    }
    if !arguments.seeds.is_empty() {
        let seeds = &arguments.seeds;
        if seeds.iter().enumerate().any(|(i, s)| seeds[..i].contains(s)) {
            return Err(CliError::Usage("--seeds: a seed is there twice".into()));
        }
        sweep.seeds.clone_from(seeds);
    }
    if !arguments.data.is_empty() {
        let absolute = |p: &PathBuf| std::path::absolute(p).unwrap_or_else(|_| p.clone());
        let paths: Vec<String> =
            arguments.data.iter().map(|p| absolute(p).display().to_string()).collect();
        sweep.experiment.insert("recordings".into(), paths.into());
    }
    Ok(sweep)
}

fn experiment(sweep: &Sweep, load: LoadOptions, arguments: &AblateArguments) -> TrainingExperiment {
    TrainingExperiment::new(sweep, load, &made_by())
        .with_checkpoints(Duration::from_secs_f64(arguments.checkpoint_s))
}

fn sweep(
    arguments: &AblateArguments,
    global: &GlobalOptions,
    console: &Console,
) -> Result<ExitCode, CliError> {
    if let (true, Some(name)) = (arguments.print, &arguments.sweep) {
        let text = Sweep::built_in_text(name).map(str::to_owned);
        let known = Sweep::BUILT_IN.join(", ");
        let text = text.ok_or_else(|| CliError::Usage(format!("--print is for {known}")))?;
        console.text(text.trim_end());
        console.json(&json!({ "sweep": text }));
        return Ok(ExitCode::SUCCESS);
    }
    seconds("--checkpoint-s", arguments.checkpoint_s, true)?;
    let mut sweep = asked(arguments)?;
    // Wrong settings are reported before recordings are read.
    let seen = plan(&sweep, &TrainingExperiment::without_data(&sweep, &made_by()))?;
    let experiment = experiment(&sweep, arguments.reading.load_options(global.rig()?)?, arguments);
    if arguments.list {
        if arguments.sweep.is_none() && !sweep.data.is_empty() {
            return list(arguments, &sweep, &seen, true, console);
        }
        // A list is to be had without the recordings too, but for the names of the cells.
        return match plan(&sweep, &experiment) {
            Ok(planned) => list(arguments, &sweep, &planned, true, console),
            Err(_) => list(arguments, &sweep, &seen, false, console),
        };
    }
    let planned = plan(&sweep, &experiment)?;
    sweep.data = experiment.digests();
    let Some(out) = &arguments.out else {
        return Err(CliError::Usage("give --out DIR".into()));
    };
    let folder = SweepFolder::begin(out, &sweep, arguments.extend)?;
    let configuration = json!({ "sweep": sweep, "reading": arguments.reading.to_json(global)? });
    run_record::write(out, "ablate", global.seed, &configuration)?;
    if arguments.retry_failed {
        let freed = free_failed(&planned, &folder)?;
        console.text(format!("{freed} cells that failed are run again."));
    }
    let threads = global.threads.unwrap_or_else(pam_threads);
    let options = RunOptions {
        shard: arguments.shard,
        steal: arguments.steal,
        jobs: arguments.jobs.map_or(threads, usize::from),
        threads,
        made_by: made_by(),
    };
    let stop = stop_flag();
    let progress = Progress::new(&sweep, console);
    let counts = run_cells(&planned, &experiment, &folder, &options, stop, &|event| {
        progress.tell(event);
    });
    progress.bar.finish_and_clear();
    let counts = counts?;
    let summary = write_results(&folder, &sweep, &planned, &made_by())?;
    let stopped = stop.load(Ordering::Relaxed) && counts.stopped > 0;
    tell(&folder, &sweep, &summary, Some((counts, stopped)), console);
    if stopped {
        console.text(format!("interrupted; the same command goes on with it in {}", out.display()));
        return Ok(ExitCode::from(INTERRUPTED));
    }
    Ok(code_of(&summary))
}

fn pam_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn code_of(summary: &Summary) -> ExitCode {
    if summary.done == summary.cells { ExitCode::SUCCESS } else { ExitCode::from(PARTIAL) }
}

fn merged(arguments: &MergeArguments, console: &Console) -> Result<ExitCode, CliError> {
    let sources: Vec<&Path> = arguments.folders.iter().map(PathBuf::as_path).collect();
    let out = match (&arguments.out, &sources[..]) {
        (Some(out), _) => out.as_path(),
        (None, [only]) => only,
        _ => return Err(CliError::Usage("give --out DIR for what is merged".into())),
    };
    let sweep = SweepFolder::at(sources[0]).sweep()?;
    let experiment = TrainingExperiment::without_data(&sweep, &made_by());
    let planned = plan(&sweep, &experiment)?;
    let folder = SweepFolder::begin(out, &sweep, false)?;
    merge(&sources, &folder, &sweep, &planned)?;
    let summary = write_results(&folder, &sweep, &planned, &made_by())?;
    tell(&folder, &sweep, &summary, None, console);
    Ok(code_of(&summary))
}

fn list(
    arguments: &AblateArguments,
    sweep: &Sweep,
    planned: &[Planned],
    named: bool,
    console: &Console,
) -> Result<ExitCode, CliError> {
    let records = match &arguments.out {
        Some(out) => SweepFolder::at(out).records(planned)?,
        None => vec![None; planned.len()],
    };
    let mut rows = vec![["cell", "shard", "status", "settings"].map(str::to_owned).to_vec()];
    let mut values = Vec::new();
    for (p, record) in planned.iter().zip(&records) {
        let status = record.as_ref().map_or(json!("open"), |r| json!(r.status));
        let status = status.as_str().unwrap_or_default().to_owned();
        let shard = p.cell.index % arguments.shard.count + 1;
        values.push(json!({
            "cell": named.then_some(&p.id), "shard": shard, "status": status, "settings": p.cell.describe(sweep),
        }));
        let id = if named { p.id.clone() } else { "–".into() };
        rows.push(vec![id, shard.to_string(), status, p.cell.describe(sweep)]);
    }
    console.json(&json!({ "cells": values }));
    console.text(table(&rows));
    Ok(ExitCode::SUCCESS)
}

/// Results on the console.
fn tell(
    folder: &SweepFolder,
    sweep: &Sweep,
    summary: &Summary,
    ran: Option<(RunCounts, bool)>,
    console: &Console,
) {
    let mut value = json!({ "summary": summary, "folder": folder.path(), "made_by": made_by() });
    if let Some((counts, stopped)) = ran {
        value["this_process"] = json!({
            "done": counts.done,
            "failed": counts.failed,
            "stopped": counts.stopped,
            "elsewhere": counts.elsewhere,
            "interrupted": stopped,
        });
    }
    console.json(&value);
    let Some(metric) = summary.metrics.first() else {
        console.text(format!("{}: no cell has ended with numbers", sweep.name));
        return;
    };
    let mut rows = Vec::new();
    for axis in summary.axes() {
        let head = [axis, metric, "difference", "95 % interval", "p, t", "p, Wilcoxon"];
        rows.push(head.map(str::to_owned).to_vec());
        for m in summary.means.iter().filter(|m| m.axis == axis && m.metric == *metric) {
            let mut row = vec![m.value.clone(), mean_text(m)];
            row.extend(summary.difference_texts(m));
            rows.push(row);
        }
    }
    if !summary.draws.is_empty() {
        let axes = sweep.axes.iter().map(|a| a.name.clone());
        rows.push(["best".to_owned()].into_iter().chain(axes).chain([metric.clone()]).collect());
    }
    for (k, draw) in summary.draws.iter().take(LISTED_DRAWS).enumerate() {
        let number = |(text, n): (&String, &Option<f64>)| n.map_or_else(|| text.clone(), short);
        let values = draw.values.iter().zip(&draw.numbers).map(number);
        rows.push(
            [(k + 1).to_string()].into_iter().chain(values).chain([short(draw.mean)]).collect(),
        );
    }
    let open = summary.cells - summary.done - summary.failed;
    let open = if open > 0 { format!(", {open} not over yet") } else { String::new() };
    let file = |name: &str| folder.path().join(name).display().to_string();
    console.text(format!(
        "\n{}: {} of {} cells done, {} failed{open}.\n\n{}\n\ntable: {}\nreport: {}",
        sweep.name,
        summary.done,
        summary.cells,
        summary.failed,
        table(&rows),
        file("results.csv"),
        file("report.html")
    ));
}

/// Draws of a random search that are printed.
const LISTED_DRAWS: usize = 5;

/// A bar over all cells of the process, in thousandths of a cell.
struct Progress<'a> {
    bar: ProgressBar,
    shares: Mutex<HashMap<String, f64>>,
    sweep: &'a Sweep,
    console: &'a Console,
}

const PARTS: f64 = 1000.0;

impl<'a> Progress<'a> {
    fn new(sweep: &'a Sweep, console: &'a Console) -> Self {
        let bar = console.progress(1, "cells");
        Self { bar, shares: Mutex::new(HashMap::new()), sweep, console }
    }

    fn tell(&self, event: Event<'_>) {
        match event {
            Event::Planned(cells, over) => {
                self.bar.set_length((PARTS * cells as f64) as u64);
                let over =
                    if over > 0 { format!(", {over} were done before") } else { String::new() };
                self.console.text(format!("{}: {cells} cells to run{over}.", self.sweep.name));
            }
            Event::Began(p, before) => {
                let again = if before > 0 { ", goes on" } else { "" };
                self.bar.set_message(format!("{}{again}", p.cell.describe(self.sweep)));
            }
            Event::Progress(p, share) => self.set(p, share),
            Event::Over(p, record) => {
                self.set(p, 1.0);
                if let Some(error) = &record.error {
                    let cell = p.cell.describe(self.sweep);
                    self.bar.suspend(|| self.console.warn(format!("{cell}: failed: {error}")));
                }
            }
            Event::Elsewhere(p) => self.set(p, 1.0),
            Event::Stopped(_) => {}
        }
    }

    fn set(&self, p: &Planned, share: f64) {
        let Ok(mut shares) = self.shares.lock() else { return };
        shares.insert(p.id.clone(), share);
        self.bar.set_position((PARTS * shares.values().sum::<f64>()) as u64);
    }
}
