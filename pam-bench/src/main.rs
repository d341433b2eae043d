//! The `pam-bench` command: the comparison of gradient methods.

use clap::{Parser, Subcommand};
use pam_bench::gradients::problems::own;
use pam_bench::gradients::{findings, output, parts};
use pam_bench::memory::CountingAllocator;
use pam_core::{AnyForce, JointModel, NetworkForce};
use pam_data::atomic::write_atomic;
use pam_data::load_model;
use serde_json::json;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[global_allocator]
static MEMORY: CountingAllocator = CountingAllocator;

/// Benchmarks of pam.
#[derive(Debug, Parser)]
#[command(
    name = "pam-bench",
    version,
    after_help = "Exit codes: 0 success, 1 error, 2 wrong usage."
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Compare every gradient method on every problem: error, time, memory and counts
    Gradients(GradientsArguments),
}

#[derive(Debug, clap::Args)]
struct GradientsArguments {
    /// The short form: less than half a minute instead of some minutes
    #[arg(long)]
    quick: bool,
    /// Only these methods, separated by commas; a wrong name lists them
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    methods: Vec<String>,
    /// Only these problems, separated by commas; a wrong name lists them
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    problems: Vec<String>,
    /// Also solve with this trained network (.safetensors, .eqx with LeakyReLU), at constant steps of
    /// several Runge–Kutta methods over the training conditions
    #[arg(long, value_name = "MODEL")]
    model: Option<PathBuf>,
    /// Also solve a field of your own, the problem `own`: a TOML file with `end_s`, `observations`, and the tables `start`,
    /// `parameters` and `rates`, the last with an expression for each state
    #[arg(long, value_name = "FILE.toml")]
    field: Option<PathBuf>,
    /// Most runs of which the median time is taken; long ones run once
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    /// Folder for gradients.json, gradients.csv, table.md, report.html and run.json
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print the result as JSON on the standard output instead of text
    #[arg(long)]
    json: bool,
    /// Number of threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

/// Errors of the arguments end with 2, errors of the work with 1.
enum Failure {
    Usage(String),
    Work(Box<dyn Error>),
}

impl<E: Error + 'static> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Work(Box::new(error))
    }
}

fn main() -> ExitCode {
    let Command::Gradients(arguments) = Arguments::parse().command;
    let (code, message) = match gradients(&arguments) {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Usage(message)) => (2, message),
        Err(Failure::Work(error)) => (1, error.to_string()),
    };
    eprintln!("error: {message}");
    ExitCode::from(code)
}

fn gradients(arguments: &GradientsArguments) -> Result<(), Failure> {
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global()?;
    }
    let study = if arguments.quick { parts::quick() } else { parts::full() };
    let study = match &arguments.model {
        Some(path) => parts::with_model(study, network(path)?),
        None => study,
    };
    let study = match &arguments.field {
        Some(path) => parts::with_field(study, own::read(path)?),
        None => study,
    };
    let study = study
        .with_problems(&arguments.problems)
        .and_then(|study| study.with_methods(&arguments.methods))
        .map_err(|e| Failure::Usage(e.to_string()))?
        .with_repeat(arguments.repeat as usize);
    if study.is_empty() {
        let why = "no problem of --problems is solved with a method of --methods";
        return Err(Failure::Usage(why.into()));
    }
    let result = study.run(|p| {
        if p.done % 50 == 0 || p.done == p.total {
            eprintln!("{}/{}, about {:.0} s left", p.done, p.total, p.left.as_secs_f64());
        }
    });
    let (version, git) = (env!("CARGO_PKG_VERSION"), env!("PAM_GIT_HASH"));
    output::write(&arguments.out, &result, &format!("pam-bench {version} ({git})"))?;
    let record = json!({
        "program": "pam-bench",
        "version": version,
        "git": git,
        "command": "gradients",
        "configuration": {
            "quick": arguments.quick,
            "methods": arguments.methods,
            "problems": arguments.problems,
            "model": arguments.model,
            "field": arguments.field,
            "repeat": arguments.repeat,
        },
    });
    write_atomic(arguments.out.join("run.json"), format!("{record:#}\n").as_bytes())?;
    if arguments.json {
        println!("{}", output::to_json(&result).trim_end());
    } else {
        println!("{}", output::about(&result));
        for finding in findings::findings(&result) {
            println!("- {finding}");
        }
        println!("\nreport: {}", arguments.out.join("report.html").display());
    }
    Ok(())
}

/// The model of a file whose force is a network.
fn network(path: &Path) -> Result<JointModel<f64, NetworkForce<f64>>, Failure> {
    let saved = load_model(path)?;
    if !saved.info.effects.is_empty() {
        return Err(Failure::Usage(format!(
            "--model {} is extended by effects; `pam convert --plain` writes it without them",
            path.display()
        )));
    }
    match &saved.model.force {
        AnyForce::Network(force) => Ok(saved.model.map(|v| v, |_| force.clone())),
        _ => Err(Failure::Usage(format!("--model {} holds no network", path.display()))),
    }
}
