//! The project template `templates/own-system` on a plant that shares no code with the library: a servo axis with
//! set-valued dry friction that is larger forwards than backwards, integrated here in fixed steps of 50 µs.

// A program of its own, whose items need not all be used here.
#[allow(dead_code, unreachable_pub)]
#[path = "../../templates/own-system/src/main.rs"]
mod template;

use pam::field::{Experiment, MeasuredInput};
use std::f64::consts::TAU;
use template::{Axis, diagnose_axis};

const MASS_KG: f64 = 2.0;
const MOTOR_N_V: f64 = 4.0;
const VISCOUS_N_S_MM: f64 = 0.03;
/// Dry friction forwards and backwards, N: 3 N, 15 % more one way and 15 % less the other.
const DRY_N: [f64; 2] = [3.45, 2.55];
/// The noise that the encoder really has, mm.
const NOISE_MM: f64 = 2e-3;
/// Steps of the plant in a second.
const STEPS_HZ: usize = 20_000;

/// One run of the plant: times, voltages (held), positions with noise, and the friction force without it.
struct Run {
    times_s: Vec<f64>,
    voltage_v: Vec<f64>,
    position_mm: Vec<f64>,
    friction_n: Vec<f64>,
}

impl Run {
    fn experiment(&self, name: &str) -> Experiment<MeasuredInput> {
        let inputs = [("voltage_v", self.voltage_v.as_slice())];
        let outputs = [("position_mm", self.position_mm.as_slice())];
        Experiment::sampled(name, &self.times_s, &inputs, &outputs).expect("samples in order")
    }
}

/// Gaussian numbers from a linear congruential generator (Knuth) and the method of Box and Muller.
struct Gauss(u64);

impl Gauss {
    fn uniform(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }
    fn next(&mut self) -> f64 {
        let (a, b) = (self.uniform(), self.uniform());
        (-2.0 * a.ln()).sqrt() * (TAU * b).cos()
    }
}

/// `m v̇ = k u − b v − R`, `R ∈ [−2.55, 3.45] N` at rest: the trapezoidal rule for the smooth part, dry friction as the force
/// that stops within a step if it can.
fn plant(seconds: usize, rate_hz: usize, voltage: impl Fn(f64) -> f64, seed: u64) -> Run {
    let h = 1.0 / STEPS_HZ as f64;
    let (mut x, mut v, mut random) = (0.0_f64, 0.0_f64, Gauss(seed));
    let mut run =
        Run { times_s: vec![], voltage_v: vec![], position_mm: vec![], friction_n: vec![] };
    for k in 0..seconds * rate_hz {
        let t = k as f64 / rate_hz as f64;
        // As it is stored: four decimals.
        let u = (voltage(t) * 1e4).round() * 1e-4;
        let mut friction = 0.0;
        for step in 0..STEPS_HZ / rate_hz {
            let half = 0.5 * h * VISCOUS_N_S_MM * 1e3 / MASS_KG;
            // The speed without dry friction, and what dry friction can take from it.
            let free = (v * (1.0 - half) + h * 1e3 / MASS_KG * MOTOR_N_V * u) / (1.0 + half);
            let most = DRY_N.map(|n| h * 1e3 / MASS_KG * n / (1.0 + half));
            let next = if v > 0.0 || (v == 0.0 && free > 0.0) {
                let next = free - most[0];
                // Past zero it is driven on only by more than the friction the other way.
                if next >= 0.0 { next } else { (free + most[1]).min(0.0) }
            } else {
                let next = free + most[1];
                if next <= 0.0 { next } else { (free - most[0]).max(0.0) }
            };
            if step == 0 {
                let acting = (free - next) * (1.0 + half) * MASS_KG / (h * 1e3);
                friction = VISCOUS_N_S_MM * v + acting;
                run.times_s.push(t);
                run.voltage_v.push(u);
                run.position_mm.push(x + NOISE_MM * random.next());
            }
            x += 0.5 * h * (v + next);
            v = next;
        }
        run.friction_n.push(friction);
    }
    run
}

/// Slow and fast sines of several amplitudes, with times of rest.
fn excitation(amplitude: f64, hz: f64) -> impl Fn(f64) -> f64 {
    move |t| amplitude * ((TAU * hz * t).sin() + 0.5 * (TAU * 2.7 * hz * t + 1.0).sin())
}

/// Root mean square error of the friction force on a run, as a share of its root mean square.
fn force_error(parameters: &[f64], run: &Run, experiment: &Experiment<MeasuredInput>) -> f64 {
    use pam::field::{FieldProblem, Integrator, Outputs, PidController, Tableau};
    let axis = Axis(std::array::from_fn(|k| parameters[k]));
    let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-7, 1e-7));
    let experiments = std::slice::from_ref(experiment);
    let problem = FieldProblem::new(&axis, experiments, Outputs::new([(0, 1.0)]), &integrator);
    let signals = problem.simulate(experiment, &problem.numbers(experiment)).expect("a run");
    let (mut errors, mut sizes) = (0.0, 0.0);
    for (row, &true_n) in signals.chunks_exact(3).zip(&run.friction_n) {
        // At rest friction is whatever holds the axis; the model's law says nothing of it.
        if row[1].abs() > 1.0 {
            errors += (row[2] - true_n).powi(2);
            sizes += true_n.powi(2);
        }
    }
    (errors / f64::max(sizes, f64::MIN_POSITIVE)).sqrt()
}

/// The recordings in the template are of this plant, and its program says of them what it should.
/// `UPDATE_DOCS=1` writes them again.
#[test]
fn the_recordings_of_the_template_are_diagnosed() {
    let folder =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../templates/own-system/data");
    let plans =
        [(1.6, 0.5, "run_1"), (2.4, 0.8, "run_2"), (1.2, 0.35, "run_3"), (2.0, 0.6, "run_4")];
    let mut runs = Vec::new();
    for (seed, (amplitude, hz, name)) in (11..).zip(plans) {
        let run = plant(5, 200, excitation(amplitude, hz), seed);
        let mut text = String::from("time_s,voltage_v,position_mm\n");
        for ((t, u), x) in run.times_s.iter().zip(&run.voltage_v).zip(&run.position_mm) {
            text += &format!("{t:.3},{u:.4},{x:.4}\n");
        }
        let path = folder.join(format!("{name}.csv"));
        if std::env::var_os("UPDATE_DOCS").is_some() {
            std::fs::write(&path, &text).expect("the folder is writable");
        }
        let stored = std::fs::read_to_string(&path).expect("the recording is stored");
        assert!(stored == text, "{name}: UPDATE_DOCS=1 cargo test writes it again");
        let read = Experiment::read_csv(&path, &["voltage_v"], &["position_mm"]);
        runs.push(read.expect("numbers"));
    }
    let (fitted, held_out) = runs.split_at(3);
    let found = diagnose_axis(fitted, held_out, 0.01).expect("a diagnosis");
    assert_eq!(found.named(), ["coulomb_friction", "friction_asymmetry"]);
    let json = found.to_json("axis");
    assert_eq!(json["parameter_names"][2], "coulomb_n");
    assert!(
        json["error_reduction"]["position_mm"]["rmse_after"].is_f64(),
        "{}",
        json["error_reduction"]
    );
    assert!(
        json["score"]["log_odds"].as_f64().is_some_and(|odds| odds > 10.0),
        "{}",
        json["score"]
    );
    assert!(found.residual.description.contains("position"), "{}", found.residual.description);
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    #[test]
    #[ignore = "long"]
    fn dry_friction_is_named_first_and_then_its_asymmetry_whatever_noise_is_assumed() {
        let record = |amplitude, hz, seed| plant(4, 250, excitation(amplitude, hz), seed);
        let runs = [record(1.6, 0.5, 1), record(2.4, 0.8, 2), record(1.2, 0.35, 3)];
        let runs: Vec<_> = runs.iter().zip(["1", "2", "3"]).map(|(r, n)| r.experiment(n)).collect();
        let unseen = record(2.0, 0.6, 4);
        let held_out = [unseen.experiment("held out")];
        for noise_um in [1.0, 2.0, 5.0, 10.0, 20.0] {
            let found = diagnose_axis(&runs, &held_out, 1e-3 * noise_um).expect("a diagnosis");
            println!("{noise_um} µm: {} {:?}", found.verdict, found.model.parameters);
            assert_eq!(found.named(), ["coulomb_friction", "friction_asymmetry"], "{noise_um} µm");
            let share = force_error(&found.model.parameters, &unseen, &held_out[0]);
            println!("force error {share:.5}, noise {:.5} mm", found.noise[0]);
            assert!((found.noise[0] / NOISE_MM - 1.0).abs() < 0.1, "{:?}", found.noise);
            assert!(share < 0.05, "{noise_um} µm: {share}");
        }
    }
}
