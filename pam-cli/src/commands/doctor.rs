//! `pam doctor`.

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::Console;
use crate::error::CliError;
use crate::options::default_model;
use crate::run_record::made_by;
use clap::Args;
use pam_data::atomic::write_atomic;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::json;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Arguments of `pam doctor`.
#[derive(Debug, Args)]
pub struct DoctorArguments {
    /// A folder in which runs are to be written [default: the current one]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Outcome of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Outcome {
    Ok,
    Warning,
    Failure,
}

/// One line of the list.
#[derive(Debug, Serialize)]
struct Check {
    what: &'static str,
    outcome: Outcome,
    found: String,
}

impl RunCommand for DoctorArguments {
    fn run(&self, _global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let out = self.out.clone().unwrap_or_else(|| PathBuf::from("."));
        let checks = [
            Check { what: "program", outcome: Outcome::Ok, found: made_by() },
            threads(),
            instructions(),
            model(),
            writable("write access", &out),
            writable("temporary folder", &std::env::temp_dir()),
        ];
        for check in &checks {
            let mark = match check.outcome {
                Outcome::Ok => "ok     ",
                Outcome::Warning => "warning",
                Outcome::Failure => "FAILURE",
            };
            console.text(format!("{mark}  {}: {}", check.what, check.found));
        }
        let healthy = checks.iter().all(|c| c.outcome != Outcome::Failure);
        console.json(&json!({ "healthy": healthy, "checks": checks }));
        Ok(if healthy { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}

/// Threads, and how much faster they are together than one.
fn threads() -> Check {
    let threads = rayon::current_num_threads();
    let work =
        |_: usize| (0..2_000_000_u32).fold(1.0_f64, |v, k| black_box(v * 0.999 + f64::from(k)));
    let timed = |parallel: bool| {
        let start = Instant::now();
        let sum: f64 = if parallel {
            (0..threads).into_par_iter().map(work).sum()
        } else {
            (0..threads).map(work).sum()
        };
        black_box(sum);
        start.elapsed().as_secs_f64()
    };
    timed(true);
    let speed_up = timed(false) / timed(true);
    let outcome = if speed_up < 0.6 * threads as f64 { Outcome::Warning } else { Outcome::Ok };
    let busy = if outcome == Outcome::Ok { "" } else { "; something else keeps the cores busy" };
    Check {
        what: "threads",
        outcome,
        found: format!("{threads}, together {speed_up:.1} times one{busy}"),
    }
}

fn instructions() -> Check {
    let arch = format!("{:?}", pam_core::simd::arch());
    let name = arch.split(['(', ' ', '{']).next().unwrap_or_default().to_owned();
    let (outcome, found) = match name.as_str() {
        "Scalar" => (
            Outcome::Warning,
            "none that the program knows; batches run several times slower".to_owned(),
        ),
        "V3" => (Outcome::Ok, "AVX2 and FMA".to_owned()),
        "V4" => (Outcome::Ok, "AVX-512".to_owned()),
        other => (Outcome::Ok, other.to_owned()),
    };
    Check { what: "vector instructions", outcome, found }
}

fn model() -> Check {
    match default_model() {
        Ok(saved) => Check {
            what: "default model",
            outcome: Outcome::Ok,
            found: saved.model.force.describe(),
        },
        Err(e) => Check { what: "default model", outcome: Outcome::Failure, found: e.to_string() },
    }
}

fn writable(what: &'static str, folder: &Path) -> Check {
    let probe = folder.join(format!(".pam-doctor-{}", std::process::id()));
    let written = write_atomic(&probe, b"probe\n");
    let _ = std::fs::remove_file(&probe);
    match written {
        Ok(()) => Check { what, outcome: Outcome::Ok, found: folder.display().to_string() },
        Err(e) => Check { what, outcome: Outcome::Failure, found: e.to_string() },
    }
}
