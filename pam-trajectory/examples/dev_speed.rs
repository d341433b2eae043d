//! Speed and accuracy of the surrogate engine beside steps through the network.
//!
//! ```sh
//! pam rig record --out logs
//! cargo run --release -p pam-trajectory --example surrogate_speed -- pam-cli/models/default.safetensors logs [recordings]
//! ```

use pam_data::{LoadOptions, MassOrigin, Subject, collect_paths, load_model, open_recordings};
use pam_solvers::{Interpolation, Tableau};
use pam_surrogate::SurrogateSettings;
use pam_trajectory::engine::SurrogateEngine;
use pam_trajectory::{
    BatchedEngine, SolverSettings, SquaredError, StepChoice, TrajectoryEngine, TrajectoryGradient,
    TrajectoryRequest, Windows,
};
use std::path::Path;
use std::time::Instant;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [model, logs, rest @ ..] = &arguments[..] else {
        eprintln!("usage: surrogate_speed MODEL LOGS [RECORDINGS]");
        return;
    };
    let most = rest.first().and_then(|n| n.parse().ok()).unwrap_or(usize::MAX);
    let saved = load_model(Path::new(model)).expect("a model");
    let mut paths = collect_paths(&[Path::new(logs).to_owned()]).expect("recordings");
    paths.sort();
    let subjects: Vec<Subject> = paths
        .iter()
        .take(most)
        .flat_map(|p| open_recordings(p, &LoadOptions::default()).expect("a recording"))
        .map(|recording| {
            let rest = recording.reading_at_rest();
            let kpa = [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa];
            let masses = saved.model.gas_law_masses(rest.displacement_mm, kpa);
            Subject { recording, masses, origin: MassOrigin::GasLaw }
        })
        .collect();
    let samples: usize = subjects.iter().map(|s| s.recording.len()).sum();
    println!("{} recordings, {samples} samples", subjects.len());
    let windows = Windows::of(subjects, None);
    let request = TrajectoryRequest::new(&saved.model, &windows);
    let loss = SquaredError::published();
    let linear = Interpolation::Linear;
    let tight = |tolerance: f64| SolverSettings {
        tableau: Tableau::tsit5(),
        step: StepChoice::Adaptive { rtol: tolerance, atol: tolerance },
        interpolation: linear,
    };
    let args: Vec<f64> = std::env::var("SET").unwrap_or("0.01,1e-8".into()).split(',').map(|v| v.parse().unwrap()).collect();
    let settings = SurrogateSettings { force_error_mn: args[0], step_error_mm: args[1], ..SurrogateSettings::default() };
    let mut engine = SurrogateEngine::new(linear, settings);
    let value_s = fastest(|| assert!(engine.value(&request, &loss).is_ok()));
    let mut found = None;
    let both_s = fastest(|| found = engine.value_and_gradient(&request, &loss).ok());
    let found: TrajectoryGradient = found.unwrap();
    println!("value {value_s:.4} both {both_s:.4} {:?}", found.statistics);
}

/// The shortest of three CPU times of all threads together, s; of wall-clock times where the system tells none.
fn fastest(mut run: impl FnMut()) -> f64 {
    let started = Instant::now();
    let now = || cpu_s().unwrap_or_else(|| started.elapsed().as_secs_f64());
    let times = [(); 30].map(|()| {
        let start = now();
        run();
        now() - start
    });
    times.into_iter().fold(f64::INFINITY, f64::min)
}

fn cpu_s() -> Option<f64> {
    let tasks = std::fs::read_dir("/proc/self/task").ok()?;
    let of = |task: std::fs::DirEntry| {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    };
    Some(tasks.flatten().filter_map(of).sum::<f64>() * 1e-9)
}
