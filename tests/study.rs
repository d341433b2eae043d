//! The study of the diagnosis.
//!
//! ```sh
//! # Tests are compiled with little optimisation; the plant is 2.5 times as fast with all of it.
//! cargo build --release -p pam-tests --features studies --example study --config 'profile.release.package.pam-tests.opt-level=3'
//! study list                                  # cases with their factors
//! study run --only nulls --jobs 2             # resumable; into results/diagnosis
//! study show singles-031 --out case           # one case: outcome, diagnosis, report, model and recordings
//! study check --only singles                  # faults that the plausibility checks reject
//! study tables                                # criteria with exact binomial limits
//! study limits results/diagnosis              # recompute the detection limits of stored outcomes
//! study coverage results/diagnosis results/diagnosis_second_design --out coverage.csv # coverage of intervals over several designs
//! study run --design 20261 --every 8 --out new # cases that nobody has seen
//! ```

use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use pam_data::atomic::write_atomic;
use pam_data::formats::list::write_recording;
use pam_data::models::save_model;
use pam_data::plausibility::{self, Severity};
use pam_tests::plant::Hidden;
use pam_tests::study::data::{data, sized};
use pam_tests::study::{Case, Outcome, Source, design, outcome, rows, store, tables};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Folder of the results, from the root of the repository.
const RESULTS: &str = "results/diagnosis";

#[derive(Parser)]
#[command(about = "Study of the diagnosis: a seeded design of cases with known truth")]
struct Arguments {
    /// Seed of the design; with another one every case is new.
    #[arg(long, global = true, default_value_t = design::SEED)]
    design: u64,
    #[command(subcommand)]
    command: Action,
}

#[derive(Subcommand)]
enum Action {
    /// List the cases and their factors.
    List {
        /// Cases whose id contains this, or after ^ begins with it.
        #[arg(long, default_value = "")]
        only: String,
        /// As JSON, one case per line.
        #[arg(long)]
        json: bool,
    },
    /// Run cases that have no outcome yet.
    Run {
        /// Cases whose id contains this, or after ^ begins with it.
        #[arg(long, default_value = "")]
        only: String,
        /// Every so-manieth of them.
        #[arg(long, default_value_t = 1)]
        every: usize,
        /// Cases at a time.
        #[arg(long, default_value_t = 1)]
        jobs: usize,
        /// Folder of the outcomes.
        #[arg(long, default_value = RESULTS)]
        out: PathBuf,
    },
    /// Run the plausibility checks alone and print the cases that they reject: a fault must not be taken for a wrong input.
    Check {
        /// Cases whose id contains this, or after ^ begins with it.
        #[arg(long, default_value = "")]
        only: String,
        /// Every so-manieth of them.
        #[arg(long, default_value_t = 1)]
        every: usize,
    },
    /// Run one case and print its outcome.
    Show {
        /// Its id.
        case: String,
        /// Folder for outcome.json, diagnosis.json, report.html, the model, the recordings and the baseline.
        #[arg(long)]
        out: Option<PathBuf>,
        /// Folder of outcomes into which it is stored.
        #[arg(long)]
        store: Option<PathBuf>,
    },
    /// Print the criteria and write criteria.csv and tables.md beside the outcomes.
    Tables {
        /// Folder of the outcomes.
        #[arg(default_value = RESULTS)]
        folder: PathBuf,
    },
    /// Recompute the sizes of the hidden effects of stored outcomes, relative to the detection limit.
    Limits {
        /// Folder of the outcomes.
        folder: PathBuf,
    },
    /// Print how often the intervals of each parameter hold the truth, over several folders together.
    Coverage {
        /// Folders of outcomes, each of another design.
        #[arg(required = true)]
        folders: Vec<PathBuf>,
        /// CSV to which the table is written as well.
        #[arg(long)]
        out: Option<PathBuf>,
    },
}

fn main() -> ExitCode {
    let Arguments { design, command } = Arguments::parse();
    let result = match command {
        Action::List { only, json } => list(design, &only, json),
        Action::Run { only, every, jobs, out } => run(design, (&only, every), jobs, &out),
        Action::Check { only, every } => check(design, &only, every),
        Action::Show { case, out, store } => show(design, &case, out.as_deref(), store.as_deref()),
        Action::Tables { folder } => write_tables(&folder),
        Action::Limits { folder } => limits(&folder),
        Action::Coverage { folders, out } => coverage(&folders, out.as_deref()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

/// The cases of the design of a seed and the rows.
fn cases(seed: u64) -> Vec<Case> {
    let rows = rows::all().into_iter().map(|r| r.case);
    design::of_seed(seed).into_iter().chain(rows).collect()
}

fn selected(seed: u64, only: &str) -> Vec<Case> {
    let is_meant = |id: &str| match only.strip_prefix('^') {
        Some(beginning) => id.starts_with(beginning),
        None => id.contains(only),
    };
    cases(seed).into_iter().filter(|c| is_meant(&c.id)).collect()
}

fn list(seed: u64, only: &str, json: bool) -> Result<(), String> {
    for case in selected(seed, only) {
        if json {
            println!("{}", serde_json::to_string(&case).map_err(|e| e.to_string())?);
            continue;
        }
        let f = &case.factors;
        println!(
            "{:<20} {:>5} Hz, {} × {} s, {:?}, noise × {} {:?}, model {:?}{}",
            case.id,
            f.rate_hz,
            f.recordings,
            f.duration_s,
            f.shape,
            f.loudness,
            f.pressure_colour,
            f.model_error,
            if f.baseline { ", baseline" } else { "" }
        );
    }
    Ok(())
}

fn check(seed: u64, only: &str, every: usize) -> Result<(), String> {
    let sound = |c: &Case| !c.factors.gauge && c.repeats.is_none();
    let all: Vec<Case> =
        selected(seed, only).into_iter().filter(sound).step_by(every.max(1)).collect();
    let refused: Vec<String> = all
        .par_iter()
        .filter_map(|case| {
            let data = data(case);
            let findings = plausibility::check(&data.model.model, &data.subjects);
            let first = findings.into_iter().find(|f| f.severity == Severity::Error)?;
            let hidden: Vec<String> = data.truth.iter().map(|t| t.hidden.text()).collect();
            Some(format!("{} ({}): {first}", case.id, hidden.join(", ")))
        })
        .collect();
    refused.iter().for_each(|case| println!("{case}"));
    println!("{} of {} cases are rejected", refused.len(), all.len());
    if refused.is_empty() { Ok(()) } else { Err("faults are taken for wrong inputs".into()) }
}

/// Every case runs in a process of its own: its CPU time is its own, and one that panics stops no other.
fn run(seed: u64, (only, every): (&str, usize), jobs: usize, out: &Path) -> Result<(), String> {
    let all: Vec<Case> = selected(seed, only).into_iter().step_by(every.max(1)).collect();
    if all.is_empty() {
        return Err(format!("no case has `{only}` in its id; `study list` shows them"));
    }
    let due: Vec<&Case> = all.iter().filter(|c| store::stored(out, c).is_none()).collect();
    let program = std::env::current_exe().map_err(|e| e.to_string())?;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = jobs.clamp(1, threads.max(1));
    let style = "[{bar:32}] {pos}/{len}  {elapsed} gone, {eta} left  {msg}";
    let bar = ProgressBar::new(all.len() as u64);
    bar.set_style(ProgressStyle::with_template(style).map_err(|e| e.to_string())?);
    bar.set_position((all.len() - due.len()) as u64);
    bar.reset_eta();
    let (next, failed) = (AtomicUsize::new(0), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| {
                while let Some(case) = due.get(next.fetch_add(1, Ordering::Relaxed)) {
                    bar.set_message(case.id.clone());
                    let status = Command::new(&program)
                        .args(["show", &case.id, "--design", &seed.to_string(), "--store"])
                        .arg(out)
                        .env("RAYON_NUM_THREADS", (threads / jobs).max(1).to_string())
                        .stdout(Stdio::null())
                        .status();
                    if !status.is_ok_and(|s| s.success()) {
                        failed.fetch_add(1, Ordering::Relaxed);
                        bar.suspend(|| eprintln!("{}: no outcome", case.id));
                    }
                    bar.inc(1);
                }
            });
        }
    });
    bar.finish_and_clear();
    report_rows(&all, out);
    match failed.into_inner() {
        0 => Ok(()),
        n => Err(format!("{n} cases have no outcome; the same command runs them again")),
    }
}

/// Prints whether the rows among the cases hold.
fn report_rows(cases: &[Case], out: &Path) {
    for row in rows::all().iter().filter(|r| cases.contains(&r.case)) {
        let Some(outcome) = store::stored(out, &row.case) else { continue };
        match (row.check)(&outcome) {
            Ok(()) => println!("pass  {:<10} {}", row.case.id, row.asked),
            Err(said) => println!("FAIL  {:<10} {}: {said}", row.case.id, row.asked),
        }
    }
}

fn show(seed: u64, id: &str, out: Option<&Path>, store: Option<&Path>) -> Result<(), String> {
    let case = cases(seed).into_iter().find(|c| c.id == id);
    let case = case.ok_or_else(|| format!("there is no case `{id}`; `study list` shows them"))?;
    let (outcome, diagnosis) = outcome::run(&case);
    print(&outcome);
    if let Some(folder) = store {
        store::store(folder, &outcome)?;
    }
    if let Some(folder) = out {
        let pretty = |v: &serde_json::Value| format!("{v:#}\n");
        let write = |name: &str, text: &str| {
            write_atomic(folder.join(name), text.as_bytes()).map_err(|e| e.to_string())
        };
        write(
            "outcome.json",
            &pretty(&serde_json::to_value(&outcome).map_err(|e| e.to_string())?),
        )?;
        if let Some((json, report)) = diagnosis {
            write("diagnosis.json", &pretty(&json))?;
            write("report.html", &report)?;
        }
        write_data(folder, &case)?;
    }
    Ok(())
}

/// The model and the recordings of a case, as `pam diagnose` reads them.
fn write_data(folder: &Path, case: &Case) -> Result<(), String> {
    let made = data(case);
    save_model(folder.join("model.safetensors"), &made.model).map_err(|e| e.to_string())?;
    let sets = [("data", Some(&made.subjects)), ("baseline", made.baseline.as_ref())];
    for (name, subjects) in sets.into_iter().filter_map(|(name, s)| Some((name, s?))) {
        let folder = folder.join(name);
        std::fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
        for (k, subject) in subjects.iter().enumerate() {
            let file = folder.join(format!("{k:02}.npz"));
            write_recording(&file, &subject.recording).map_err(|e| e.to_string())?;
        }
    }
    Ok(())
}

fn print(o: &Outcome) {
    for t in &o.truth {
        let limits = t.limits.map_or(String::new(), |l| format!(", {l:.1} limits of detection"));
        println!("hidden  {}{limits}", t.hidden.text());
    }
    let reason = o.error.as_deref().unwrap_or_default();
    println!("verdict {} {reason}", o.verdict);
    for c in &o.causes {
        let minor = if c.minor { " (minor)" } else { "" };
        println!("cause   {}{minor} ~ {:?} {:?}", c.effect, c.confusable_with, c.parameters);
    }
    println!("before / noise {:?}, reduction {:?}", o.over_noise, o.reduction);
    println!("{:.1} s, CPU {:.1} s", o.wall_s, o.cpu_s.unwrap_or(f64::NAN));
}

fn write_tables(folder: &Path) -> Result<(), String> {
    let outcomes = store::all(folder)?;
    let markdown = tables::markdown(&outcomes);
    print!("{markdown}");
    let write = |name: &str, text: &str| {
        write_atomic(folder.join(name), text.as_bytes()).map_err(|e| e.to_string())
    };
    write("tables.md", &markdown)?;
    write("criteria.csv", &tables::csv(&outcomes)?)
}

/// Sizes of rig cases are derived from rig recordings and are not changed.
fn limits(folder: &Path) -> Result<(), String> {
    let of_plant = |o: &Outcome| o.case.factors.source == Source::Plant && !o.truth.is_empty();
    store::all(folder)?.into_par_iter().filter(of_plant).try_for_each(|mut outcome| {
        let hidden: Vec<Hidden> = outcome.truth.iter().map(|t| t.hidden.clone()).collect();
        for (truth, sized) in outcome.truth.iter_mut().zip(sized(&outcome.case, &hidden)) {
            (truth.limits, truth.limits_beside) = (sized.limits, sized.limits_beside);
        }
        store::store(folder, &outcome)
    })
}

fn coverage(folders: &[PathBuf], out: Option<&Path>) -> Result<(), String> {
    let mut outcomes = Vec::new();
    for folder in folders {
        outcomes.extend(store::all(folder)?);
    }
    print!("{}", tables::coverage_markdown(&outcomes));
    let Some(out) = out else { return Ok(()) };
    write_atomic(out, tables::coverage_csv(&outcomes)?.as_bytes()).map_err(|e| e.to_string())
}
