//! Speed and accuracy of the surrogate engine beside steps through the network: of a model at several tolerances, and of its
//! weights with other smooth activations at the default ones.
//!
//! ```sh
//! pam rig record --out logs
//! cargo bench -p pam-trajectory --bench surrogate_speed -- pam-cli/models/default.safetensors logs [recordings]
//! ```

use pam_core::{Activation, AnyForce, ForceModel, JointModel, Mlp, NetworkForce};
use pam_data::{LoadOptions, MassOrigin, Subject, collect_paths, load_model, open_recordings};
use pam_solvers::{Interpolation, Tableau};
use pam_surrogate::SurrogateSettings;
use pam_trajectory::engine::{EngineForce, SurrogateEngine};
use pam_trajectory::{
    BatchedEngine, SolverSettings, SquaredError, StepChoice, TrajectoryEngine, TrajectoryGradient,
    TrajectoryRequest, Windows,
};
use std::path::Path;
use std::time::Instant;

const LINEAR: Interpolation = Interpolation::Linear;
/// Errors of the force, mN, and of a step, mm.
const TOLERANCES: [(f64, f64); 6] =
    [(0.01, 3e-10), (0.02, 1e-9), (0.02, 3e-9), (0.05, 5e-9), (0.1, 1e-8), (0.3, 1e-7)];
const ACTIVATIONS: [&str; 3] = ["gelu", "softplus", "elu"];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
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
    let of = |(force_error_mn, step_error_mm): (f64, f64)| SurrogateSettings {
        force_error_mn,
        step_error_mm,
        ..SurrogateSettings::default()
    };
    compare("the model", &saved.model, &windows, &TOLERANCES.map(of), true);
    let Some(network) = saved.model.force.network() else { return };
    for name in ACTIVATIONS {
        let activation = Activation::from_name(name).expect("an activation");
        let mlp = Mlp::new(network.mlp().layers().to_vec(), activation).expect("a network");
        let model = saved
            .model
            .clone()
            .map(|v| v, |_| AnyForce::from(NetworkForce::new(mlp).expect("a force")));
        compare(name, &model, &windows, &[SurrogateSettings::default()], false);
    }
}

/// Times and errors of a model on surrogates of these settings.
fn compare<F: EngineForce>(
    name: &str,
    model: &JointModel<f64, F>,
    windows: &Windows,
    settings: &[SurrogateSettings],
    with_steps: bool,
) {
    let request = TrajectoryRequest::new(model, windows);
    let loss = SquaredError::published();
    // Whole numbers of steps between samples: none passes a corner of the force.
    let mut reference = BatchedEngine::<f64>::new(SolverSettings {
        tableau: Tableau::tsit5(),
        step: StepChoice::Constant { step_s: 2.5e-4 },
        interpolation: LINEAR,
    });
    let start = Instant::now();
    let truth = match reference.value_and_gradient(&request, &loss) {
        Ok(truth) if truth.failures.is_empty() => truth,
        other => return println!("{name}: no reference: {:?}", other.map(|t| t.failures)),
    };
    println!("{name}: reference {:.2} s, {:.12e}", start.elapsed().as_secs_f64(), truth.value);
    let expected: Vec<Vec<f64>> = (0..windows.subjects().len())
        .map(|k| {
            let states = TrajectoryEngine::<F>::predicted(&mut reference, k);
            states.iter().map(|y| y[0]).collect()
        })
        .collect();
    let report = |name: &str, engine: &mut dyn TrajectoryEngine<F>| {
        let value_s = fastest(|| assert!(engine.value(&request, &loss).is_ok()));
        let mut found = None;
        let both_s = fastest(|| found = engine.value_and_gradient(&request, &loss).ok());
        let found: TrajectoryGradient = found.expect("a gradient");
        let norm = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
        let apart: Vec<f64> = found.force.iter().zip(&truth.force).map(|(a, b)| a - b).collect();
        let mut worst: f64 = 0.0;
        for (k, expected) in expected.iter().enumerate() {
            let pairs = engine.predicted(k).iter().zip(expected);
            worst = pairs.map(|(a, b)| (a[0] - b).abs()).fold(worst, f64::max);
        }
        println!(
            "{name}: value {value_s:.3} s, value and gradient {both_s:.3} s; displacement off {worst:.1e} mm, value off {:.1e}, gradient off {:.1e}; {:?}, {} failures",
            (found.value / truth.value - 1.0).abs(),
            norm(&apart) / norm(&truth.force),
            found.statistics,
            found.failures.len(),
        );
    };
    for &settings in settings {
        let mut engine = SurrogateEngine::new(LINEAR, settings);
        let (force, step) = (settings.force_error_mn, settings.step_error_mm);
        report(&format!("    surrogate, {force} mN and {step:e} mm"), &mut engine);
    }
    if with_steps {
        let rk4 = SolverSettings {
            tableau: Tableau::rk4(),
            step: StepChoice::Constant { step_s: 5e-3 },
            interpolation: LINEAR,
        };
        report("    RK4 at 5 ms, f32", &mut BatchedEngine::<f32>::new(rk4));
    }
}

/// The shortest of three CPU times of all threads together, s; of wall-clock times where the system tells none.
fn fastest(mut run: impl FnMut()) -> f64 {
    let started = Instant::now();
    let now = || cpu_s().unwrap_or_else(|| started.elapsed().as_secs_f64());
    let times = [(); 3].map(|()| {
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
