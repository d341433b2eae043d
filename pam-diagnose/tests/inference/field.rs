//! The diagnosis of a vector field has every part of that of the joint: an oscillator with a hidden term.

use pam_core::{ParametricField, Scalar, VectorField};
use pam_diagnose::Verdict;
use pam_diagnose::data::TestData;
use pam_diagnose::field::{
    Candidate, FieldDiagnosis, FieldOptions, design_field, diagnose_field, sine_experiments,
};
use pam_diagnose::report::{ReportContext, diagnosis_report};
use pam_effects::effects::ParameterInfo;
use pam_expression::Terms;
use pam_solvers::{InputFn, Integrator, ParametricInput, PidController, SaveAt, Tableau, Term};
use pam_train::field::{Experiment, FieldProblem, Outputs};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::f64::consts::TAU;

/// `ẍ = u − k x − c ẋ − f tanh(ẋ/0.05) − g tanh(ẋ/0.08) − q x³ − l`, with k, c, f, g, q, l.
#[derive(Clone, Copy)]
struct Oscillator<S>([S; 6]);

impl<S: Scalar> VectorField<S> for Oscillator<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        1
    }
    fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
        let [k, c, f, g, q, l] = self.0;
        let (x, v) = (y[0], y[1]);
        let friction = f * v.scaled(1.0 / 0.05).tanh() + g * v.scaled(1.0 / 0.08).tanh();
        dy[0] = v;
        dy[1] = u[0] - k * x - c * v - friction - q * x * x * x - l;
    }
}

impl ParametricField for Oscillator<f64> {
    type With<S: Scalar> = Oscillator<S>;
    fn parameters(&self) -> Vec<f64> {
        self.0.to_vec()
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> Oscillator<S> {
        Oscillator(std::array::from_fn(|i| p[i]))
    }
}

const STIFFNESS: f64 = 4.0;
const FRICTION: f64 = 0.3;
const NOISE: f64 = 0.01;
/// By how much the given initial position is wrong.
const START_ERROR: f64 = 0.1;

fn plant(friction: f64) -> Oscillator<f64> {
    Oscillator([STIFFNESS, 0.3, friction, 0.0, 0.0, 0.0])
}

fn integrator() -> Integrator<PidController> {
    Integrator::new(Tableau::tsit5(), PidController::new(1e-6, 1e-6))
}

fn record(
    plant: Oscillator<f64>,
    amplitude: f64,
    hz: f64,
    seed: u64,
) -> Experiment<impl ParametricInput + Sync + Clone> {
    let input = InputFn::new(1, move |t: f64, u: &mut [f64]| {
        u[0] = amplitude * ((TAU * hz * t).sin() + 0.4 * (TAU * 2.3 * hz * t).sin());
    });
    let times_s: Vec<f64> = (0..500).map(|k| 0.05 * f64::from(k)).collect();
    let real = Term::new(plant, input);
    let y0 = [START_ERROR, 0.0];
    let run = integrator().solve(&real, 0.0, times_s[499], &y0, SaveAt::Times(&times_s)).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let noise = Normal::new(0.0, NOISE).unwrap();
    let measured = run.component(0).map(|x| x + noise.sample(&mut random)).collect();
    Experiment::new(&format!("{amplitude} at {hz} Hz"), input, times_s, measured)
        .starting_at(vec![0.0, 0.0])
}

/// As [`record`], with the friction of the plant from a time on.
fn record_from(
    plant: Oscillator<f64>,
    onset_s: f64,
    amplitude: f64,
    hz: f64,
    seed: u64,
) -> Experiment<impl ParametricInput + Sync + Clone> {
    let whole = record(plant, amplitude, hz, seed);
    let without = Oscillator([plant.0[0], plant.0[1], 0.0, plant.0[3], plant.0[4], plant.0[5]]);
    let mut plain = record(without, amplitude, hz, seed);
    if onset_s <= 0.0 {
        return whole;
    }
    // The state at the onset goes on with friction.
    let rows = plain.times_s.partition_point(|t| *t < onset_s);
    if rows == plain.times_s.len() {
        return plain;
    }
    let input = whole.input.clone();
    let (start, y0) = (plain.times_s[0], [START_ERROR, 0.0]);
    let before = Term::new(without, input.clone());
    let at = integrator().solve(&before, start, onset_s, &y0, SaveAt::Times(&[onset_s])).unwrap();
    let behind = Term::new(plant, input);
    let (times, end_s) = (plain.times_s[rows..].to_vec(), plain.times_s[plain.times_s.len() - 1]);
    let y: Vec<f64> = (0..2).map(|i| at.component(i).last().unwrap()).collect();
    let run = integrator().solve(&behind, onset_s, end_s, &y, SaveAt::Times(&times)).unwrap();
    // The same noise as without friction.
    let clean = Term::new(without, plain.input.clone());
    let quiet =
        integrator().solve(&clean, start, end_s, &y0, SaveAt::Times(&plain.times_s)).unwrap();
    let quiet: Vec<f64> = quiet.component(0).collect();
    for (k, x) in run.component(0).enumerate() {
        plain.measured[rows + k] += x - quiet[rows + k];
    }
    plain
}

fn candidates() -> Vec<Candidate> {
    let one = |name, index, parameter| {
        let info = ParameterInfo::linear(parameter, [-10.0, 10.0]).meaning("a term of the field");
        Candidate::one(name, index, info, &[0.1])
    };
    vec![
        one("dry_friction", 2, "friction_m_s2"),
        one("soft_friction", 3, "friction_m_s2"),
        one("cubic_spring", 4, "stiffness_per_m2_s2"),
        one("load", 5, "load_m_s2"),
    ]
}

fn options() -> FieldOptions {
    FieldOptions {
        refitted: vec![0],
        initial_state_deviation: Some(vec![0.1, 0.0]),
        ..FieldOptions::default()
    }
}

/// The diagnosis of runs of the plant with friction, by the model without and these terms as candidates.
fn diagnosed_with(terms: Terms) -> FieldDiagnosis {
    let model = terms.onto(plant(0.0));
    let runs = [(1.0, 0.2), (1.5, 0.25), (0.8, 0.4), (1.2, 0.3)];
    let experiments: Vec<_> =
        (0..4).zip(runs).map(|(k, (a, hz))| record(plant(FRICTION), a, hz, k)).collect();
    let integrator = integrator();
    let problem =
        FieldProblem::new(&model, &experiments, Outputs::of_unknown_noise([0]), &integrator);
    diagnose_field(&problem, &Candidate::of_terms(&model), &options()).unwrap()
}

/// Terms as expressions are candidates like those that are written into the field: the plant is in Rust.
#[test]
fn terms_of_a_field_are_expressions() {
    let info = |name| ParameterInfo::linear(name, [-10.0, 10.0]);
    let terms = Terms::new(&["x", "v"], &["u"])
        .term("dry_friction", &[(info("f"), 0.1)], &[("v", "-f * tanh(v / 0.05)")])
        .and_then(|t| t.term("cubic_spring", &[(info("q"), 0.1)], &[("v", "-q * x^3")]))
        .and_then(|t| t.term("load", &[(info("l"), 0.1)], &[("v", "-l")]))
        .expect("they can be read");
    let found = diagnosed_with(terms);
    assert_eq!(
        (found.verdict, found.named()),
        (Verdict::Explained, vec!["dry_friction"]),
        "{:?}",
        found.reasons
    );
    let (name, friction) = found.causes[0].parameters[0];
    assert!(name == "f" && friction.contains(FRICTION), "{friction:?}");
}

/// Of two terms that are nearly the same, the data know the sum only: each may be absent, and both together may not.
#[test]
fn a_cause_is_there_though_each_of_its_parameters_may_be_absent() {
    let info = |name| ParameterInfo::linear(name, [-10.0, 10.0]);
    let action = [("v", "-f * tanh(v / 0.05) - g * tanh(v / 0.0505)")];
    let terms = Terms::new(&["x", "v"], &["u"])
        .term("dry_friction", &[(info("f"), 0.1), (info("g"), 0.1)], &action)
        .and_then(|t| t.term("load", &[(info("l"), 0.1)], &[("v", "-l")]))
        .expect("they can be read");
    let found = diagnosed_with(terms);
    assert_eq!(found.named(), ["dry_friction"], "{:?}", found.refused);
    let [(_, f), (_, g)] = found.causes[0].parameters[..] else { panic!("two parameters") };
    assert!(f.contains(0.0) && g.contains(0.0), "{f:?} {g:?}");
    assert!((f.value + g.value - FRICTION).abs() < 0.1 * FRICTION, "{f:?} {g:?}");
}

/// Dry friction begins at 13.7 s in the second of four runs and is there from then on: it is named with that time, and not as
/// something that is always there.
#[test]
fn a_term_of_a_field_begins_at_a_time() {
    let runs = [(1.0, 0.2), (1.5, 0.25), (0.8, 0.4), (1.2, 0.3), (0.9, 0.35), (1.1, 0.22)];
    let experiments: Vec<_> = (0..6)
        .zip(runs)
        .map(|(k, (a, hz))| {
            let onset_s = [f64::INFINITY, 13.7, 0.0, 0.0, 0.0, 0.0][k as usize];
            record_from(plant(FRICTION), onset_s, a, hz, k)
        })
        .collect();
    let integrator = integrator();
    let model = plant(0.0);
    let outputs = Outputs::of_unknown_noise([0]);
    let problem = FieldProblem::new(&model, &experiments, outputs, &integrator);
    let found = diagnose_field(&problem, &candidates(), &options()).unwrap();
    assert_eq!(found.named(), ["dry_friction"], "{:?} {:?}", found.verdict, found.reasons);
    let cause = &found.causes[0];
    let acts = cause.acts.as_ref().expect("it is not there always");
    let of = |k: usize| acts.recordings[k].acts;
    println!("{:?} {}", found.verdict, acts.sentence("dry_friction"));
    assert_eq!((acts.pattern, of(0), of(2), of(5)), ("once", "never", "always", "always"));
    assert!(cause.parameters[0].1.contains(FRICTION), "{:?}", cause.parameters);
    // The open runs are drawn; the one with the time may be a test run, of which nothing but its place is known.
    if of(1) == "begins" {
        let onset = acts.recordings[1].times["onset_s"];
        assert!((onset.value - 13.7).abs() < 0.2 && onset.contains(13.7), "{onset:?}");
    }
}

/// The field misses dry friction, has a stiffness that is 5 % too large, initial positions that are wrong by ten times
/// the noise, and a noise that nobody states.
#[test]
fn a_field_has_every_part_of_a_diagnosis() {
    let model = Oscillator([1.05 * STIFFNESS, 0.3, 0.0, 0.0, 0.0, 0.0]);
    let runs = [(1.0, 0.2), (1.5, 0.25), (0.8, 0.4), (1.2, 0.3)];
    let experiments: Vec<_> =
        (0..4).zip(runs).map(|(k, (a, hz))| record(plant(FRICTION), a, hz, k)).collect();
    let integrator = integrator();
    let outputs = Outputs::of_unknown_noise([0]);
    let problem = FieldProblem::new(&model, &experiments, outputs, &integrator);
    let candidates = candidates();
    let found = diagnose_field(&problem, &candidates, &options()).unwrap();
    println!("{:?} {:?}", found.verdict, found.causes);
    println!("{:?} {:?}", found.error_reduction, found.explainable);
    println!("{:?}", found.refused);

    // The cause with its interval, and what it is confusable with.
    assert_eq!((found.verdict, found.named()), (Verdict::Explained, vec!["dry_friction"]));
    let cause = &found.causes[0];
    let (name, friction) = cause.parameters[0];
    assert_eq!((name, cause.description.as_str()), ("friction_m_s2", "a term of the field"));
    assert!(friction.contains(FRICTION) && friction.ci95[1] - friction.ci95[0] < 0.2 * FRICTION);
    assert!(cause.share_of_error_removed > 0.8, "{}", cause.share_of_error_removed);
    assert_eq!(cause.confusable_with, ["soft_friction"]);

    // A noise level from the data: that of the sensor, and 0.4 % of the motion.
    let motion = found.error_reduction.channels[0].rmse_before;
    assert!(found.noise[0] > 0.85 * NOISE && found.noise[0] < 1.3 * NOISE, "{:?}", found.noise);
    assert!(motion > 5.0 * NOISE);

    // A test set that was not fitted, on which the refitted model, as it is returned, has the noise for an error; the wrong
    // start is no part of it after a few seconds.
    let TestData::Kept { recordings } = &found.test else { panic!("{:?}", found.test) };
    assert!(!recordings.is_empty() && recordings.iter().all(|r| !found.fitted.contains(r)));
    assert_eq!(found.fitted.len() + recordings.len(), 4);
    assert!((found.model.parameters[0] / STIFFNESS - 1.0).abs() < 0.01, "{:?}", found.model);
    let trace = &found.traces[0];
    let late = trace.time_s.partition_point(|t| *t < 15.0);
    let errors = trace.measured[0][late..].iter().zip(&trace.after[0][late..]);
    let rest = errors.map(|(m, y)| (m - y).powi(2)).sum::<f64>();
    let rest = (rest / (trace.time_s.len() - late) as f64).sqrt();
    assert!(rest < 1.2 * NOISE, "{rest}");
    assert!(found.error_reduction.overall.ci95[0] > 0.0, "{:?}", found.error_reduction.overall);
    assert!(!found.error_reduction.by_frequency.is_empty());
    assert_eq!(found.error_reduction.by_recording.len(), recordings.len());

    // Null test, stability in three parts of each fitted recording, the flexible reference.
    let null = found.null_test.unwrap();
    assert!(null.p_value < 0.05 && null.named_share > null.share_q95, "{null:?}");
    let stability = cause.stability.as_ref().unwrap();
    assert_eq!(stability.parts.len(), 3 * found.fitted.len());
    assert!(stability.relative_spread < 0.2, "{}", stability.relative_spread);
    assert!(found.explainable.named > 0.8, "{:?}", found.explainable);
    assert!((0.0..=1.0).contains(&found.explainable.any_correction));

    // Planned experiments, the one that separates friction from soft friction best first.
    let planned = sine_experiments(&problem);
    let designed = design_field(&problem, &candidates, &options(), &found, &planned);
    assert_eq!(designed.len(), 9);
    assert!(designed.windows(2).all(|w| w[0].least() >= w[1].least()));
    assert_eq!(designed[0].by_alternative[0].0, "soft_friction");
    assert!(designed[0].least() > 0.0 && designed[0].least().is_finite());

    written(&found);
}

/// Report and JSON as for the joint.
fn written(found: &FieldDiagnosis) {
    let json = found.to_json("model");
    assert_eq!(json["verdict"], "explained");
    let cause = &json["causes"][0];
    assert_eq!(cause["effect"], "dry_friction");
    assert_eq!(cause["confusable_with"][0], "soft_friction");
    let numbers = [
        &cause["parameters"]["friction_m_s2"]["value"],
        &cause["parameters"]["friction_m_s2"]["ci95"][1],
        &cause["share_of_error_removed"],
        &cause["stability"]["relative_spread"],
        &json["ranking"][0]["score"],
        &json["error_reduction"]["state_0"]["rmse_after"],
        &json["error_reduction"]["overall"]["ci95"][0],
        &json["residual"]["channels"]["state_0"]["noise"],
        &json["explainable"]["any_correction"],
        &json["null_test"]["p_value"],
        &json["parameters"][0],
    ];
    for (k, number) in numbers.iter().enumerate() {
        assert!(number.is_f64(), "number {k}: {number}");
    }
    assert_eq!(json["test"]["kind"], "kept");
    assert!(json["validation"]["kind"].is_string() && json["fitted"][0].is_string());

    let context = ReportContext { model: "oscillator".into(), ..ReportContext::default() };
    let page = diagnosis_report(found, &context);
    for text in ["oscillator", "dry_friction", "soft_friction", "a term of the field", "<svg"] {
        assert!(page.contains(text), "{text}");
    }
    for outside in ["<script src", "<link", "<img", "url(http", "@import"] {
        assert!(!page.contains(outside), "the page needs {outside}");
    }
}

/// The diagnosis of runs in which nothing is missing but the start is wrong, with this deviation of the initial position.
fn with_wrong_starts(count: u64, deviation: f64, baseline: usize) -> FieldDiagnosis {
    let experiments: Vec<_> = (0..count).map(|k| record(plant(0.0), 1.0, 0.2, k)).collect();
    let integrator = integrator();
    let model = plant(0.0);
    let outputs = Outputs::new([(0, NOISE)]);
    let problem = FieldProblem::new(&model, &experiments, outputs, &integrator);
    let initial_state_deviation = Some(vec![deviation, 0.0]);
    let options = FieldOptions { initial_state_deviation, baseline, ..FieldOptions::default() };
    diagnose_field(&problem, &candidates(), &options).unwrap()
}

/// Without free initial states their error stays in the residual; with them it goes.
#[test]
fn initial_states_are_free_where_they_are_uncertain() {
    let left = |deviation: f64| {
        let found = with_wrong_starts(3, deviation, 0);
        (found.verdict, found.residual.channels[0].rms_left)
    };
    let (free, known) = (left(0.1), left(0.0));
    assert_eq!(free.0, Verdict::NothingFound);
    assert!((free.1 / NOISE - 1.0).abs() < 0.1, "{free:?}");
    assert!(known.1 > 1.2 * NOISE, "{known:?}");
}

/// Initial states that are further off than their deviation says are an error of their own, unless baseline experiments have them
/// as well.
#[test]
fn initial_states_may_be_as_wrong_as_in_the_baseline() {
    let with = |baseline: usize| {
        let found = with_wrong_starts(6, 0.1 * START_ERROR, baseline);
        (found.verdict, found.anomalies.iter().any(|a| a.kind == "start"))
    };
    assert_eq!(with(0), (Verdict::Unexplained, true));
    assert_eq!(with(3), (Verdict::NothingFound, false));
}

/// Of a single experiment the last third is the test set. With other measurements there, and a noise that is estimated,
/// every name and value is the same bit for bit.
#[test]
fn the_last_third_of_a_single_experiment_is_not_seen() {
    let clean = [record(plant(FRICTION), 1.0, 0.2, 1)];
    let mut other = clean.clone();
    let from = 500 - 500 / 3 + 1;
    other[0].measured[from..].iter_mut().for_each(|x| *x = 1.03 * *x + 0.02);
    let integrator = integrator();
    let model = plant(0.0);
    let diagnosed = |experiments: &[Experiment<_>]| {
        let outputs = Outputs::of_unknown_noise([0]);
        let problem = FieldProblem::new(&model, experiments, outputs, &integrator);
        diagnose_field(&problem, &candidates(), &options()).unwrap()
    };
    let (a, b) = (diagnosed(&clean), diagnosed(&other));
    let decisions = |d: &FieldDiagnosis| {
        let json = d.to_json("model");
        let keys = ["causes", "ranking", "residual", "null_test", "parameters"];
        (format!("{:?} {:?}", d.causes, d.noise), keys.map(|key| json[key].clone()))
    };
    assert_eq!(a.test, b.test);
    assert!(matches!(a.test, TestData::LastPart { .. }));
    assert_eq!(decisions(&a), decisions(&b));
    let rmse = |d: &FieldDiagnosis| d.error_reduction.channels[0].rmse_before;
    assert!((rmse(&b) - rmse(&a)).abs() > 1e-3, "{} {}", rmse(&b), rmse(&a));
    // The verdict reads the test data, where something has changed.
    assert_eq!((a.verdict, b.verdict), (Verdict::Explained, Verdict::PartlyExplained));
}
