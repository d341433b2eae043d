//! Gives models of extreme, finite numbers to the commands, and measures how long an answer or an error takes.
//!
//! ```sh
//! cargo build --release
//! cargo run --release -p pam-tests --features studies --example extremes -- --out results/hardening/extremes.json
//! ```
//!
//! With `--settings` the model is the default one, and each setting of a diagnosis is at either end of its range.
//!
//! The models are the published one with weights, activation, parameters, geometry or damping changed by many orders of
//! magnitude. Recordings are those of the virtual rig, 70 s long. A run is sound if it ends with an exit code of its own,
//! an error names itself, and neither takes more than 10 s: of CPU time on one thread, or on the wall on several
//! (`--threads 2`, on an idle machine).

use clap::Parser;
use pam_core::{Activation, AnyForce, Mlp, NetworkForce, ParametricForce};
use pam_data::models::save_model;
use pam_data::{SavedModel, load_model};
use pam_diagnose::DiagnosisSettings;
use pam_tests::fuzz::LONGEST;
use pam_tests::{ended_within, published_weights, text};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

#[derive(Parser)]
struct Arguments {
    /// The program
    #[arg(long, default_value = "target/release/pam")]
    program: PathBuf,
    /// Where the times go
    #[arg(long)]
    out: Option<PathBuf>,
    /// Only models or settings whose name contains this
    #[arg(long, default_value = "")]
    model: String,
    /// Only these commands, separated by commas
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Threads of the program
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Settings of a diagnosis in the place of models
    #[arg(long)]
    settings: bool,
}

/// The commands; `DATA` are the recordings, `OUT` is the output.
const COMMANDS: &[(&str, &str)] = &[
    ("evaluate", "evaluate --accept --data DATA --out OUT"),
    ("evaluate, Tsit5", "evaluate --accept --method tsit5 --data DATA --out OUT"),
    ("gradient", "gradient --accept --data DATA --out OUT.npz"),
    ("simulate", "simulate --force sine:A=60,f=1 --duration 70 --out OUT.csv"),
    ("stiffness", "stiffness --out OUT"),
    ("plan", "plan --motion sine:A=1,f=0.5 --stiffness 150 --out OUT"),
    ("replan", "replan --out OUT"),
    ("identify", "identify --out OUT"),
    ("diagnose", "diagnose --accept --data DATA --out OUT"),
    ("diagnose without a law", "diagnose --accept --no-law --data DATA --out OUT"),
];

/// Groups of settings that matter to laws alone; the others are tried without.
const OF_LAWS: &str = "remainder.";

/// Each setting of a diagnosis at either end of its range, as arguments.
fn settings() -> Vec<String> {
    let defaults = serde_json::to_value(DiagnosisSettings::default()).expect("settings are JSON");
    let all = DiagnosisSettings::ranges().into_iter().flat_map(|(key, range)| {
        let (group, name) = key.split_once('.').expect("a key has a group");
        let default = &defaults[group][name];
        range.map(|value| match default {
            Value::Array(all) => format!("{key}={:?}", vec![value; all.len()]),
            Value::Number(n) if n.is_u64() => format!("{key}={value:.0}"),
            _ => format!("{key}={value:?}"),
        })
    });
    all.collect()
}

/// Longest time on the wall, which a busy machine stretches.
const PATIENCE: Duration = Duration::from_secs(180);

/// The published model, changed.
fn models() -> Vec<(String, SavedModel)> {
    let published = load_model(published_weights()).expect("the published model can be read");
    let mut models = vec![("as published".to_owned(), published.clone())];
    let mut add = |name: String, change: &dyn Fn(&mut SavedModel)| {
        let mut saved = published.clone();
        change(&mut saved);
        models.push((name, saved));
    };
    for (activation, scales) in [
        ("leaky_relu", &[0.0, 1e1, 1e2, 1e3, 1e4, 1e6, 1e8, 1e30, 1e100][..]),
        ("silu", &[1.0, 1e2, 1e4, 1e6, 1e8, 1e100]),
        ("tanh", &[1e2, 1e8]),
    ] {
        for &scale in scales {
            add(format!("{activation}, weights × {scale:e}"), &|s| scaled(s, activation, scale));
        }
    }
    for damping in [-1e3, 1e3, 1e6, 1e12, 1e300, -1e300] {
        add(format!("B = {damping:e} kg/s"), &|s| s.model.auxiliary_damping_kg_s = damping);
    }
    for raw in [-1e300, -50.0, 0.0, 1e-300, 1.0, 1e3, 1e6, 1e9, 1e12, 1e300] {
        add(format!("raw mass {raw:e}"), &|s| s.model.raw.mass = raw);
        add(format!("raw gas coefficient {raw:e}"), &|s| s.model.raw.gas_coefficient = raw);
        add(format!("raw deformation {raw:e}"), &|s| s.model.raw.deformation = raw);
    }
    models
}

/// Multiplies all weights and biases.
fn scaled(saved: &mut SavedModel, activation: &str, scale: f64) {
    let AnyForce::Network(network) = &saved.model.force else { return };
    let weights: Vec<f64> = network.parameters().iter().map(|w| scale * w).collect();
    let layers = network.with_parameters(&weights).mlp().layers().to_vec();
    let activation = Activation::from_name(activation).expect("a known activation");
    let mlp = Mlp::new(layers, activation).expect("layers that fit");
    saved.model.force = AnyForce::Network(NetworkForce::new(mlp).expect("a network of the force"));
}

/// Processor time of children that have ended, as Linux counts it in hundredths of a second.
fn children_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit_once(')').map_or("", |(_, rest)| rest).split_whitespace().skip(13);
    fields.take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

fn command(program: &Path, line: &str, (data, out): (&Path, &Path), threads: usize) -> Command {
    let mut command = Command::new(program);
    let put = |part: &str| part.replace("DATA", text(data)).replace("OUT", text(out));
    command.args(line.split(' ').map(put)).args(["--quiet", "--threads", &threads.to_string()]);
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

/// How runs ended.
#[derive(Default)]
struct Tally {
    answers: usize,
    refusals: usize,
    slowest: (f64, String),
    wrong: Vec<(String, String)>,
}

impl Tally {
    /// Runs a command to its end.
    fn add(&mut self, what: &str, mut command: Command, threads: usize) {
        let (before_s, start) = (children_s(), Instant::now());
        let mut child = command.spawn().expect("the program starts");
        if ended_within(&mut child, PATIENCE).is_none() {
            child.kill().expect("the child can be ended");
        }
        let output = child.wait_with_output().expect("the program ends");
        let took_s = match threads {
            1 => children_s() - before_s,
            _ => start.elapsed().as_secs_f64(),
        };
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        let refused = message.contains("error: ") && !message.contains("panicked");
        if took_s > LONGEST.as_secs_f64() {
            self.wrong.push((what.to_owned(), format!("{took_s:.1} s")));
        } else {
            match output.status.code() {
                Some(0 | 3) => self.answers += 1,
                Some(1) if refused => self.refusals += 1,
                code => {
                    self.wrong.push((what.to_owned(), format!("exit {code:?}: {}", message.trim())))
                }
            }
        }
        if took_s > self.slowest.0 {
            self.slowest = (took_s, what.to_owned());
        }
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let program = std::path::absolute(&arguments.program).expect("the program has a path");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let data = folder.path().join("data");
    let record =
        command(&program, "rig record --conditions 45/45 --no-truth --out OUT", (&data, &data), 1);
    assert!({ record }.status().expect("the program starts").success(), "no recordings");
    let file = folder.path().join("model.safetensors");
    let (mut runs, mut wrong, mut by_command) = (0, Vec::new(), serde_json::Map::new());
    let models = if arguments.settings { Vec::new() } else { models() };
    let settings = if arguments.settings { settings() } else { Vec::new() };
    for (name, line) in COMMANDS {
        if !arguments.only.is_empty() && !arguments.only.iter().any(|n| n == name) {
            continue;
        }
        let mut tally = Tally::default();
        let mut ended = |what: &str, more: &[&str]| {
            let made = tempfile::tempdir_in(folder.path()).expect("a temporary folder");
            let out = made.path().join("out");
            let mut command = command(&program, line, (&data, &out), arguments.threads);
            command.args(more);
            tally.add(what, command, arguments.threads);
        };
        for (model, saved) in models.iter().filter(|(name, _)| name.contains(&arguments.model)) {
            save_model(&file, saved).expect("the model can be written");
            ended(model, &["--model", text(&file)]);
        }
        let of_command = |s: &&String| {
            line.starts_with("diagnose") && s.starts_with(OF_LAWS) != line.contains("--no-law")
        };
        for setting in settings.iter().filter(of_command) {
            if setting.contains(&arguments.model) {
                ended(setting, &["--set", setting]);
            }
        }
        runs += tally.answers + tally.refusals + tally.wrong.len();
        wrong.extend(tally.wrong.iter().map(|(what, why)| json!([name, what, why])));
        let (slowest_s, slowest) = &tally.slowest;
        let row = json!({ "answers": tally.answers, "refusals": tally.refusals, "slowest_s": slowest_s, "slowest": slowest });
        eprintln!("{name}: {row}");
        by_command.insert((*name).to_owned(), row);
    }
    let value = json!({
        "command": "cargo run --release -p pam-tests --features studies --example extremes",
        "threads": arguments.threads,
        "models": models.len(),
        "settings": settings.len(),
        "runs": runs,
        "by_command": by_command,
        "wrong": wrong,
        "longest_allowed_s": LONGEST.as_secs(),
    });
    let printed = format!("{value:#}\n");
    print!("{printed}");
    if let Some(path) = &arguments.out {
        pam_data::atomic::write_atomic(path, printed.as_bytes()).expect("the times can be written");
    }
    if wrong.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
