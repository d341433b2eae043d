//! Comparisons on recordings of a joint that is known exactly.

mod config;
mod result;

use pam_baselines::comparison::{
    Comparison, ComparisonConfig, Event, ModelCache, Split, compare, split,
};
use pam_baselines::method::{FittedModel, FreeRun, Run, TrainingSet};
use pam_baselines::{AnyMethod, BaselineError};
use pam_core::{JointModel, PhysicalParameters, SealedMasses, SpringDamper};
use pam_data::Subject;
use pam_data::{MassOrigin, Recording};
use pam_trajectory::{Predictor, SolverSettings, predict};
use std::path::Path;

/// Recordings of a linear joint under sines of 0.5, 1 and 2 Hz, 10 s at 250 Hz, at several pressures.
fn recordings() -> Vec<Recording> {
    let mut force = SpringDamper::constant(60e3, 6500.0);
    force.stiffness_per_mass_mn_mm_g = 400e3;
    force.shift_per_mass_mm_g = 8.0;
    let mut model = JointModel::datasheet(force);
    let mass_kg = 300.0;
    let deformation = 3.7;
    model.raw =
        PhysicalParameters { mass_kg, deformation, ..PhysicalParameters::datasheet() }.to_raw();
    let psi = [[10, 10], [45, 45], [80, 80], [30, 60], [60, 30], [20, 70], [50, 40], [35, 55]];
    psi.iter()
        .map(|[f, e]| {
            let kpa = |p: i32| f64::from(p) * 6.89476 + 101.325;
            let mut r = Recording::empty(Path::new(&format!("nn_{f}{e}")));
            for k in 0..2500 {
                let t = f64::from(k) * 4e-3;
                let frequency = [0.5, 0.5, 0.5, 1.0, 2.0][k as usize / 500];
                r.time_s.push(t);
                r.force_mn.push(1.4e5 * (std::f64::consts::TAU * frequency * t).sin());
            }
            // At rest in equilibrium: F = 0 at x = s (m_f − m_e).
            let masses = model.gas_law_masses(0.0, [kpa(*f), kpa(*e)]);
            let x = 8.0 * (masses.flexor_g - masses.extensor_g);
            let [pf, pe] = model.gas_law_pressures_kpa(x, masses);
            r.displacement_mm = vec![x; 2500];
            r.velocity_mm_s = vec![0.0; 2500];
            r.pressure_flexor_kpa = vec![pf; 2500];
            r.pressure_extensor_kpa = vec![pe; 2500];
            let settings = SolverSettings::default();
            let p = predict(&model, &r, masses, &settings).unwrap();
            p.to_recording(&r, masses)
        })
        .map(|mut r| {
            // The masses are for the models to find.
            r.given_masses = None;
            r
        })
        .collect()
}

fn subjects() -> Vec<Subject> {
    let masses = SealedMasses { flexor_g: 0.1, extensor_g: 0.1 };
    recordings()
        .into_iter()
        .map(|recording| Subject { recording, masses, origin: MassOrigin::GasLaw })
        .collect()
}

const SMALL: &str = "
[data]
recordings = []
train = [\"1010\", \"4545\", \"8080\", \"3060\", \"6030\", \"2070\"]
[evaluation]
warm_up = 50
[[model]]
kind = \"koopman\"
dictionary = \"second_order\"
[[model]]
kind = \"koopman\"
dictionary = \"second_order\"
rollout = \"lifted\"
[[model]]
kind = \"spring_damper\"
[[model]]
kind = \"equilibrium_point\"
[[model]]
kind = \"sparse_force\"
[[model]]
kind = \"gru\"
hidden = 16
warm_up = 50
horizon = 20
samples_per_step = 4
rollout = 3
batch = 40
updates_per_epoch = 3
epochs = 2
[[model]]
kind = \"neural_ode\"
width = 16
updates = 20
steps_per_window = 20
[[model]]
kind = \"kang\"
";

fn config(text: &str) -> ComparisonConfig {
    ComparisonConfig::parse(text, Path::new("small.toml")).unwrap()
}

fn run(config: &ComparisonConfig, sets: &Split) -> Comparison {
    compare(config, sets, None, 1, None, &|_| true).unwrap()
}

#[test]
fn models_that_hold_the_truth_predict_it_and_others_do_not() {
    let config = config(SMALL);
    let sets = split(&config, subjects()).unwrap();
    assert_eq!((sets.train.len(), sets.held_out.len()), (6, 2));
    let c = run(&config, &sets);
    let held = |name: &str| {
        let m = c.models.iter().find(|m| m.result.name == name).unwrap();
        m.result.cold.held_out.displacement
    };
    // Both forms hold the linear joint; what is left is smoothing, and for the first the bilinear law.
    assert!(
        held("Linear spring–damper").mean.unwrap() > 0.9995,
        "{:?}",
        held("Linear spring–damper")
    );
    assert!(
        held("Sparse force (SINDy)").mean.unwrap() > 0.999,
        "{:?}",
        held("Sparse force (SINDy)")
    );
    // The line of stiffness over pressures is nearly that over masses.
    assert!(held("Equilibrium point").mean.unwrap() > 0.9);
    // Muscles of another make pull this joint elsewhere.
    assert!(held("Kang analytical").mean.is_none_or(|m| m < 0.9));

    let spring = &c.models.iter().find(|m| m.result.kind == "spring_damper").unwrap().result;
    // The joint was driven by a held force, half a sample (2 ms) behind the one that is regressed on: what
    // that looks like is an inertia of m + B h/2 = 300 + 6500 · 0.002 kg.
    let mass = spring.details["mass_kg"].as_f64().unwrap();
    assert!((mass - 313.0).abs() < 2.0, "{}", spring.details);
    assert!((spring.details["deformation"].as_f64().unwrap() - 3.7).abs() < 0.02);
    assert!(spring.mechanics.stiffness_error_percent.unwrap() < 2.0, "{:?}", spring.mechanics);
    assert!(spring.mechanics.force_r2.unwrap() > 0.999);
    let frequencies: Vec<f64> = spring.cold.held_out.by_frequency.iter().map(|(f, _)| *f).collect();
    assert_eq!(frequencies, [0.5, 1.0, 2.0]);

    // The tables hold every model and both starts.
    let csv = c.to_csv();
    assert_eq!(csv.lines().count(), 1 + c.models.len());
    let columns = csv.lines().next().unwrap().split(',').count();
    assert_eq!(columns, 4 + 4 * (5 + 3) + 3);
    assert_eq!(c.recordings_csv().lines().count(), 1 + c.models.len() * 2 * 8);
    let tex = c.to_latex();
    let notes = tex.matches("multicolumn{11}").count();
    assert_eq!(tex.matches("\\\\\n").count(), 2 + c.models.len() + notes);
    let html = c.report("test");
    for m in &c.models {
        assert!(html.contains(&m.result.name) && tex.contains("Kang analytical$^{*}$"));
    }
}

#[test]
fn numbers_repeat_from_the_seed_at_any_number_of_threads_and_resumed() {
    let config = config(SMALL);
    let sets = split(&config, subjects()).unwrap();
    let with = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| compare(&config, &sets, None, seed, None, &|_| true).unwrap().to_json())
    };
    let one = with(1, 1);
    assert_eq!(one.to_string(), with(3, 1).to_string());
    assert_ne!(one.to_string(), with(3, 2).to_string());

    // Stopped after three models, resumed to the same bits without fitting those again.
    let folder = tempfile::tempdir().unwrap();
    let done = std::sync::atomic::AtomicUsize::new(0);
    let stop = |event: Event<'_>| {
        use std::sync::atomic::Ordering::Relaxed;
        !(matches!(event, Event::Done(_)) && done.fetch_add(1, Relaxed) == 2)
    };
    let keep = ModelCache { folder: folder.path(), resume: false, program: "one" };
    let stopped = compare(&config, &sets, None, 1, Some(keep), &stop);
    assert!(matches!(stopped, Err(BaselineError::Interrupted)));
    let kept = std::sync::Mutex::new(Vec::new());
    let note = |event: Event<'_>| {
        if let Event::Kept(name) = event {
            kept.lock().unwrap().push(name.to_owned());
        }
        true
    };
    let keep = ModelCache { resume: true, ..keep };
    let resumed = compare(&config, &sets, None, 1, Some(keep), &note).unwrap();
    assert_eq!(resumed.to_json().to_string(), one.to_string());
    assert_eq!(kept.lock().unwrap().len(), 3);
    // Another seed, program or sample takes nothing over.
    let mut quick = config.clone();
    quick.models.retain(|m| m.name == "Linear spring–damper");
    let mut nudged = sets.clone();
    nudged.held_out[0].recording.pressure_flexor_kpa[7] += 1e-9;
    let taken = |seed: u64, program: &str, sets: &Split| {
        kept.lock().unwrap().clear();
        let keep = ModelCache { program, ..keep };
        compare(&quick, sets, None, seed, Some(keep), &note).unwrap();
        kept.lock().unwrap().len()
    };
    assert_eq!(taken(1, "one", &sets), 1);
    assert_eq!(taken(5, "one", &sets), 0);
    assert_eq!(taken(5, "one", &sets), 1);
    assert_eq!(taken(5, "two", &sets), 0);
    assert_eq!(taken(5, "two", &nudged), 0);
    assert_eq!(taken(5, "two", &nudged), 1);
}

/// Names that differ by marks alone have the same letters.
#[test]
fn models_whose_names_look_alike_are_kept_apart() {
    let text = "[data]\nrecordings = [\".\"]\ntrain = \"all\"\nheld_out = \"none\"\n\
        [[model]]\nname = \"A+\"\nkind = \"spring_damper\"\n\
        [[model]]\nname = \"A-\"\nkind = \"koopman\"\n[[model]]\nname = \"±\"\nkind = \"spring_damper\"\n";
    let config = ComparisonConfig::parse(text, Path::new("c.toml")).unwrap();
    let sets = split(&config, subjects()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let keep = ModelCache { folder: folder.path(), resume: false, program: "one" };
    let all = |_: Event<'_>| true;
    let first = compare(&config, &sets, None, 1, Some(keep), &all).unwrap();
    let kept = |name: &str| pam_data::formats::npz::read(&folder.path().join("models").join(name));
    let (plus, minus) = (kept("a.npz").unwrap(), kept("a-2.npz").unwrap());
    assert_ne!(plus.keys().collect::<Vec<_>>(), minus.keys().collect::<Vec<_>>());
    assert!(kept("model.npz").is_ok());
    // A result that was edited is none: the model is fitted again.
    let path = folder.path().join("models/a.json");
    let edited = std::fs::read_to_string(&path).unwrap().replacen("0.", "1.", 1);
    std::fs::write(&path, edited).unwrap();
    let fitted = std::sync::atomic::AtomicUsize::new(0);
    let count = |event: Event<'_>| {
        if let Event::Done(_) = event {
            fitted.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        }
        true
    };
    let keep = ModelCache { resume: true, ..keep };
    let again = compare(&config, &sets, None, 1, Some(keep), &count).unwrap();
    assert_eq!(fitted.into_inner(), 1);
    assert_eq!(again.to_json(), first.to_json());

    // A name that no recording has is told.
    let unknown = text.replace("train = \"all\"", "train = [\"nn_3060\", \"nobody\"]");
    let unknown = ComparisonConfig::parse(&unknown, Path::new("c.toml")).unwrap();
    let message = split(&unknown, subjects()).unwrap_err().to_string();
    assert!(message.contains("`nobody`"), "{message}");
}

#[test]
fn a_warm_start_is_the_measured_state_and_a_cold_one_the_first_sample() {
    let subjects = subjects();
    let training = TrainingSet { subjects: &subjects[..6], surfaces: None, seed: 1 };
    for method in AnyMethod::defaults() {
        if matches!(method, AnyMethod::Hybrid(_) | AnyMethod::Gru(_) | AnyMethod::NeuralOde(_)) {
            continue;
        }
        let model = method.method().fit(&training, &|_| true).unwrap();
        let s = &subjects[7];
        for start in [0, 50] {
            let run = Run { recording: &s.recording, masses: s.masses, start };
            let Ok(t) = model.simulate(&run) else { continue };
            assert_eq!(t.x.len(), s.recording.len() - start, "{}", method.kind());
            assert_eq!(t.x[0], s.recording.displacement_mm[start]);
        }
        free_run(&*model, s);
    }
}

/// As a predictor of pam-train a model predicts the same from the first sample.
fn free_run(model: &dyn FittedModel, s: &Subject) {
    let settings = SolverSettings::default();
    let run = Run { recording: &s.recording, masses: s.masses, start: 0 };
    match (FreeRun(model).predict(&s.recording, s.masses, &settings), model.simulate(&run)) {
        (Ok(p), Ok(t)) => {
            assert_eq!(p.channels.x, t.x);
            assert_eq!(p.len(), s.recording.len());
        }
        (Err(e), Err(stopped)) => assert_eq!(e.why, stopped.why),
        _ => panic!("one stops and the other does not"),
    }
}

#[test]
fn what_cannot_be_fitted_is_told() {
    let config = config(SMALL);
    let mut only_held = config.clone();
    only_held.data.train = pam_train::curriculum::Selection::Names(vec!["9999".into()]);
    let message = split(&only_held, subjects()).unwrap_err().to_string();
    assert!(message.contains("data.train"), "{message}");
    let mut short = config;
    short.evaluation.warm_up = 5000;
    let message = split(&short, subjects()).unwrap_err().to_string();
    assert!(message.contains("warm-up"), "{message}");
    // Two rates of sampling are no discrete-time model.
    let mut all = subjects();
    for t in &mut all[1].recording.time_s {
        *t *= 2.0;
    }
    let training = TrainingSet { subjects: &all, surfaces: None, seed: 1 };
    let koopman = pam_baselines::koopman::Koopman::default();
    let message = koopman.regress(training.subjects).unwrap_err().to_string();
    assert!(message.contains("0.008") || message.contains("0.004"), "{message}");
}
