//! Fits of fields whose solutions are known in closed form.

use pam_autodiff::ByTape;
use pam_core::{DryFriction, FieldNames, ParametricField, Scalar, VectorField};
use pam_solvers::sensitivity::DiscreteAdjoint;
use pam_solvers::{Integrator, Interpolation, NoInput, PidController, Tableau};
use pam_train::field::{
    Experiment, FieldError, FieldProblem, FieldTraining, LeastSquares, MeasuredInput, Numbers,
    Outputs, outputs_error,
};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// A lag with a sensor: `ẏ = (u − y)/τ`, output `g y + u`.
struct Lag<S> {
    time_s: S,
    gain: S,
}

impl<S: Scalar> VectorField<S> for Lag<S> {
    fn state_len(&self) -> usize {
        1
    }
    fn input_len(&self) -> usize {
        1
    }
    fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
        dy[0] = (u[0] - y[0]) / self.time_s;
    }
    fn output_len(&self) -> usize {
        1
    }
    fn outputs_into(&self, _t: f64, y: &[S], u: &[S], out: &mut [S]) {
        out[0] = self.gain * y[0] + u[0];
    }
}

impl ParametricField for Lag<f64> {
    type With<S: Scalar> = Lag<S>;
    fn parameters(&self) -> Vec<f64> {
        vec![self.time_s, self.gain]
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> Lag<S> {
        Lag { time_s: p[0], gain: p[1] }
    }
    fn names(&self) -> FieldNames {
        FieldNames::new(&["level_mm"], &["flow_v"], &["sensor_v"], &["time_s", "gain"])
    }
}

const TIME_S: f64 = 0.3;
const GAIN: f64 = 2.5;

fn integrator() -> Integrator<PidController> {
    Integrator::new(Tableau::tsit5(), PidController::new(1e-9, 1e-9))
}

fn times() -> Vec<f64> {
    (0..200).map(|k| 0.01 * f64::from(k)).collect()
}

/// A step of the input from 0 to 1 at 0.5 s that the lag sees `delay_s` later, from a start at `y0`: the level, and the
/// sensor, which sees the delayed input as well.
fn step(delay_s: f64, y0: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let times = times();
    let voltage: Vec<f64> = times.iter().map(|&t| f64::from(u8::from(t > 0.495))).collect();
    let exact = |t: f64| {
        let free = y0 * (-t / TIME_S).exp();
        let since = t - 0.5 - delay_s;
        free + if since > 0.0 { 1.0 - (-since / TIME_S).exp() } else { 0.0 }
    };
    let level: Vec<f64> = times.iter().map(|&t| exact(t)).collect();
    let delayed = |t: f64| f64::from(u8::from(t - delay_s > 0.495));
    let sensor = times.iter().zip(&level).map(|(&t, y)| GAIN * y + delayed(t)).collect();
    (voltage, level, sensor)
}

/// Experiments that own their samples can be made in a function.
fn of_sensor(y0: f64, noise: f64, seed: u64) -> Experiment<MeasuredInput> {
    let (voltage, _, mut sensor) = step(0.0, y0);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, noise).expect("a deviation");
    sensor.iter_mut().for_each(|s| *s += normal.sample(&mut random));
    Experiment::sampled("step", &times(), &[("flow_v", &voltage)], &[("sensor_v", &sensor)])
        .expect("samples in order")
        .starting_at(vec![y0])
}

/// Only a sensor `h(y, u)` is measured, no state.
#[test]
fn an_output_of_state_and_input_is_fitted() {
    let (integrator, guess) = (integrator(), Lag { time_s: 0.1, gain: 1.0 });
    let outputs = Outputs::named(&guess, [("sensor_v", 1e-3)]).expect("a name");
    assert_eq!(outputs.signals, [1]);
    let (experiments, held_out) = ([of_sensor(0.0, 0.0, 1)], [of_sensor(0.4, 0.0, 2)]);
    let problem = FieldProblem::new(&guess, &experiments, outputs.clone(), &integrator)
        .with_held_out(&held_out);
    let fit = problem.least_squares(&LeastSquares::default()).expect("a fit");
    assert!((fit.parameters[0] - TIME_S).abs() < 1e-6 && (fit.parameters[1] - GAIN).abs() < 1e-6);
    assert!(fit.held_out[0].rms[0] < 1e-6, "{:?}", fit.held_out);

    // The gradient of a loss of the output goes through state, and directly through the gain.
    let loss = outputs_error(problem.signal_len(), outputs);
    let method = DiscreteAdjoint::new(ByTape);
    let value = |p: &[f64]| problem.value_and_gradient(p, &loss, &method).expect("a value");
    let at = [0.2, 1.5];
    let (_, gradient) = value(&at);
    for k in 0..2 {
        let moved = |by: f64| {
            let mut p = at;
            p[k] += by;
            value(&p).0
        };
        let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
        assert!((gradient[k] / slope - 1.0).abs() < 1e-5, "{k}: {} {slope}", gradient[k]);
    }
    let trained =
        problem.train(&loss, &method, &FieldTraining::default(), |_, _| true).expect("training");
    assert!((trained.parameters[1] - GAIN).abs() < 1e-3, "{:?}", trained.parameters);
    let [before, after] = trained.held_out.expect("held out");
    assert!(after < 1e-4 * before);
}

/// Initial states and the delay of the input are fitted along with the parameters.
#[test]
fn initial_states_and_a_delay_are_fitted() {
    let (integrator, guess) = (integrator(), Lag { time_s: 0.2, gain: 0.0 });
    let delay_s = 0.04;
    let run = |y0: f64| {
        let (voltage, level, _) = step(delay_s, y0);
        Experiment::sampled("step", &times(), &[("flow_v", &voltage)], &[("level_mm", &level)])
            .expect("samples in order")
            .starting_at(vec![0.0])
    };
    let experiments = [run(0.3), run(-0.1)];
    let outputs = Outputs::new([(0, 1e-3)]);
    let problem = FieldProblem::new(&guess, &experiments, outputs, &integrator);
    let settings = LeastSquares {
        free: Some(vec![0]),
        logarithmic: vec![0],
        initial_state_deviation: Some(vec![1.0]),
        delay_deviation_s: 0.1,
        ..LeastSquares::default()
    };
    let fit = problem.least_squares(&settings).expect("a fit");
    assert!((fit.parameters[0] - TIME_S).abs() < 1e-3, "{fit:?}");
    let [delay, error] = fit.delay_s.expect("it was fitted");
    assert!((delay - delay_s).abs() < 1e-3, "{delay}");
    assert!(error < 0.01);
    assert!((fit.initial_states[0][0] - 0.3).abs() < 1e-3, "{:?}", fit.initial_states);
    assert!((fit.initial_states[1][0] + 0.1).abs() < 1e-3, "{:?}", fit.initial_states);
    // Symmetric in the logarithm.
    let [low, high] = fit.interval(0).expect("it was fitted");
    assert!((low * high / fit.parameters[0].powi(2) - 1.0).abs() < 1e-12);
}

/// A noise that nobody states is learned, and a positive parameter stays positive from a start ten times too large.
#[test]
fn noise_is_learned_and_scales_stay_positive() {
    let (integrator, guess) = (integrator(), Lag { time_s: 3.0, gain: GAIN });
    let experiments = [of_sensor(0.0, 0.02, 1), of_sensor(0.5, 0.02, 2)];
    let problem =
        FieldProblem::new(&guess, &experiments, Outputs::of_unknown_noise([1]), &integrator);
    let settings = LeastSquares { logarithmic: vec![0], ..LeastSquares::default() };
    let fit = problem.least_squares(&settings).expect("a fit");
    assert!((fit.noise[0] / 0.02 - 1.0).abs() < 0.1, "{:?}", fit.noise);
    let [low, high] = fit.interval(0).expect("it was fitted");
    assert!(low > 0.0 && low < TIME_S && TIME_S < high && high < 1.1 * low, "{low} {high}");
}

/// A sledge, `v̇ = u − c σ`, that starts with 1 mm/s and is not driven: it stops after `1/2c`.
struct Sledge<S>(S);

impl<S: Scalar> VectorField<S> for Sledge<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        1
    }
    fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
        dy[0] = y[1];
        dy[1] = -self.0 * u[0];
    }
}

impl ParametricField for Sledge<f64> {
    type With<S: Scalar> = Sledge<S>;
    fn parameters(&self) -> Vec<f64> {
        vec![self.0]
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> Sledge<S> {
        Sledge(p[0])
    }
    fn dry_friction(&self) -> Option<DryFriction> {
        Some(DryFriction { velocity: 1, direction: 0 })
    }
}

#[test]
fn a_field_that_sticks_is_fitted() {
    let (integrator, friction) = (integrator(), 0.8_f64);
    let times: Vec<f64> = (0..100).map(|k| 0.03 * f64::from(k)).collect();
    let position = |t: f64| {
        let t = t.min(1.0 / friction);
        t - 0.5 * friction * t * t
    };
    let measured = times.iter().map(|&t| position(t)).collect();
    let runs = [Experiment::new("slide", NoInput, times, measured).starting_at(vec![0.0, 1.0])];
    let guess = Sledge(0.5);
    let problem = FieldProblem::new(&guess, &runs, Outputs::new([(0, 1e-3)]), &integrator);
    let fit = problem.least_squares(&LeastSquares::default()).expect("a fit");
    assert!((fit.parameters[0] - friction).abs() < 1e-6, "{}", fit.parameters[0]);
    let numbers = Numbers { parameters: fit.parameters, ..problem.numbers(&runs[0]) };
    let signals = problem.simulate(&runs[0], &numbers).expect("a run");
    assert_eq!(signals[199], 0.0, "it rests");

    let loss = outputs_error(2, Outputs::new([(0, 1e-3)]));
    let method = DiscreteAdjoint::new(ByTape);
    let refused = problem.train(&loss, &method, &FieldTraining::default(), |_, _| true);
    assert!(matches!(refused, Err(FieldError::Shape(_))));
}

/// Names are compared, and told.
#[test]
fn misplaced_names_are_refused() {
    let (integrator, guess) = (integrator(), Lag { time_s: 0.2, gain: 1.0 });
    let (voltage, level, _) = step(0.0, 0.0);
    let run = Experiment::sampled(
        "run",
        &times(),
        &[("pressure_kpa", &voltage)],
        &[("level_mm", &level)],
    )
    .expect("samples in order")
    .read_by(Interpolation::Linear);
    let runs = [run];
    let problem = FieldProblem::new(&guess, &runs, Outputs::new([(0, 1.0)]), &integrator);
    let Err(FieldError::Shape(why)) = problem.least_squares(&LeastSquares::default()) else {
        panic!("a pressure is no flow");
    };
    assert!(why.contains("pressure_kpa") && why.contains("flow_v"), "{why}");
    let Err(FieldError::Shape(why)) = Outputs::named(&guess, [("force_n", 1.0)]) else {
        panic!("there is no force");
    };
    assert!(why.contains("level_mm") && why.contains("sensor_v"), "{why}");
}
