//! Batched solves give the trajectories, gradients and failures of single solves, and the same bits at
//! any number of threads and any size of batch.

use pam_autodiff::batch::{Pointwise, SealedMotion};
use pam_autodiff::{ByChunk, ByHand, ByTape, DifferentiableField, Differentiation};
use pam_core::force::{Dense, Mlp};
use pam_core::{
    Activation, JointModel, NetworkForce, ParametricField, Scalar, SealedMasses, VectorField,
};
use pam_solvers::sensitivity::{DiscreteAdjoint, Gradient, GradientMethod, Problem};
use pam_solvers::{
    BatchGradient, BatchWorkspace, BatchedIntegrator, ConstantStep, FailureKind, Fixed, Integrator,
    Interpolation, PidController, SampledInput, StepController, Tableau, TrajectoryProblem,
};

/// `ẍ = μ (1 − x²) ẋ − x + u`
#[derive(Clone, Copy)]
struct VanDerPol<S> {
    mu: S,
}

impl<S: Scalar> VectorField<S> for VanDerPol<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        1
    }
    fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
        dy[0] = y[1];
        dy[1] = self.mu * (S::constant(1.0) - y[0] * y[0]) * y[1] - y[0] + u[0];
    }
}

impl ParametricField for VanDerPol<f64> {
    type With<S: Scalar> = VanDerPol<S>;
    fn parameters(&self) -> Vec<f64> {
        vec![self.mu]
    }
    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> VanDerPol<S> {
        VanDerPol { mu: parameters[0] }
    }
}

/// A weighted square of all states with weights that tell samples and states apart.
fn loss(states: &[f64], cotangents: &mut [f64]) -> f64 {
    let mut sum = 0.0;
    for (k, (y, c)) in states.iter().zip(cotangents).enumerate() {
        let weight = 1.0 + 0.3 * (k as f64 * 0.7).sin();
        sum += 0.5 * weight * y * y;
        *c = weight * y;
    }
    sum
}

fn relative(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    norm(&mut a.iter().zip(b).map(|(a, b)| a - b)) / norm(&mut b.iter().copied()).max(1e-300)
}

/// Uneven runs: different lengths, starts and forces.
struct Run {
    times: Vec<f64>,
    force: Vec<f64>,
    observe: Vec<f64>,
    y0: Vec<f64>,
    mu: f64,
}

fn runs() -> Vec<Run> {
    (0..7)
        .map(|i| {
            let samples = 40 + 17 * i;
            let times: Vec<f64> = (0..samples).map(|k| 0.1 + 0.05 * k as f64).collect();
            let force =
                (0..samples).map(|k| 0.4 * (0.37 * k as f64 + i as f64).sin()).collect::<Vec<_>>();
            let last = times[samples - 1];
            // The start, sample times, times between, the end.
            let mut observe: Vec<f64> = (0..9).map(|k| 0.1 + 0.21 * f64::from(k)).collect();
            observe.push(last);
            let y0 = vec![0.5 + 0.1 * i as f64, -0.3];
            Run { times, force, observe, y0, mu: 0.5 + 0.3 * i as f64 }
        })
        .collect()
}

fn in_batches<C: StepController + Sync>(
    runs: &[Run],
    interpolation: Interpolation,
    batched: &BatchedIntegrator<C>,
    threads: usize,
) -> BatchGradient {
    let fields: Vec<VanDerPol<f64>> = runs.iter().map(|r| VanDerPol { mu: r.mu }).collect();
    let differentiation = ByChunk::<3>;
    let problems: Vec<_> = runs
        .iter()
        .zip(&fields)
        .map(|(r, field)| TrajectoryProblem {
            condition: differentiation.of(field),
            input: SampledInput::new(&r.times, &r.force, interpolation).unwrap(),
            t0: r.times[0],
            t1: r.times[r.times.len() - 1],
            y0: r.y0.clone(),
            observe_s: &r.observe,
        })
        .collect();
    let field = Pointwise::like(&problems[0].condition);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut memory = BatchWorkspace::default();
        let one = |_: usize, states: &[f64], cotangents: &mut [f64]| loss(states, cotangents);
        let first = batched.value_and_gradient(&field, &problems, &one, &mut memory);
        let again = batched.value_and_gradient(&field, &problems, &one, &mut memory);
        // NaN, the value of a failed run, equals nothing but its text.
        assert_eq!(format!("{first:?}"), format!("{again:?}"), "memory holds nothing over");
        first
    })
}

fn single<C: StepController + 'static>(
    run: &Run,
    interpolation: Interpolation,
    integrator: &Integrator<C>,
) -> Gradient {
    let field = VanDerPol { mu: run.mu };
    let input = Fixed(SampledInput::new(&run.times, &run.force, interpolation).unwrap());
    let problem = Problem {
        field: &field,
        input: &input,
        t0: run.times[0],
        t1: run.times[run.times.len() - 1],
        y0: &run.y0,
        observations_s: &run.observe,
        integrator,
    };
    let mut loss = |_: &[f64], states: &[f64], cotangents: &mut [f64]| loss(states, cotangents);
    DiscreteAdjoint::new(ByTape).value_and_gradient(&problem, &mut loss).unwrap()
}

fn compare<C: StepController + Clone + Sync + 'static>(tableau: Tableau, controller: C) {
    let runs = runs();
    for interpolation in [Interpolation::Hold, Interpolation::Linear, Interpolation::Cubic] {
        // Small batches, so that trajectories wait for a place; small blocks, so that there are several.
        let batched = BatchedIntegrator::new(tableau.clone(), controller.clone())
            .with_width(2)
            .with_block_points(20);
        let together = in_batches(&runs, interpolation, &batched, 1);
        assert!(together.failures.is_empty());
        let integrator = Integrator::new(tableau.clone(), controller.clone());
        for (i, run) in runs.iter().enumerate() {
            let alone = single(run, interpolation, &integrator);
            let what = format!("{} {interpolation:?} run {i}", tableau.name);
            // A batch computes in the same order as a single solve, so even the steps are the same.
            assert_eq!(together.values[i], alone.value, "{what}");
            assert!(relative(&together.own[i], &alone.parameters) < 1e-12, "{what}");
            assert!(relative(&together.initial_state[i], &alone.initial_state) < 1e-12, "{what}");
        }
        let wide = BatchedIntegrator::new(tableau.clone(), controller.clone());
        assert_eq!(together, in_batches(&runs, interpolation, &batched, 2), "threads");
        let wide = in_batches(&runs, interpolation, &wide, 2);
        assert_eq!((&together.values, together.evaluations), (&wide.values, wide.evaluations));
    }
}

#[test]
fn batches_equal_single_solves_under_error_control() {
    compare(Tableau::tsit5(), PidController::new(1e-5, 1e-6));
    compare(Tableau::dormand_prince5(), PidController::new(1e-4, 1e-4));
}

#[test]
fn batches_equal_single_solves_with_constant_steps() {
    compare(Tableau::tsit5(), ConstantStep::new(0.083));
    compare(Tableau::rk4(), ConstantStep::new(0.05));
}

fn network(activation: &str) -> NetworkForce<f64> {
    let layer = |inputs: usize, outputs: usize, seed: f64, scale: f64| {
        let value = |k: usize| scale * (seed + k as f64 * 1.313).sin();
        let weights: Vec<f64> = (0..inputs * outputs).map(value).collect();
        Dense::from_rows(&weights, (0..outputs).map(|k| value(k + 99)).collect()).unwrap()
    };
    let layers = vec![layer(4, 24, 0.3, 0.8), layer(24, 20, 1.1, 0.3), layer(20, 1, 2.2, 3e4)];
    NetworkForce::new(Mlp::new(layers, Activation::from_name(activation).unwrap()).unwrap())
        .unwrap()
}

/// The reduced motion in a batch has the gradient of the four-state joint for a loss of the motion.
#[test]
fn the_sealed_motion_equals_the_joint() {
    for activation in ["leaky_relu", "tanh"] {
        let mut model = JointModel::datasheet(network(activation));
        model.auxiliary_damping_kg_s = 3e4;
        let masses = SealedMasses::new(0.05, 0.08).unwrap();
        let times: Vec<f64> = (0..400).map(|k| f64::from(k) * 1e-3).collect();
        let force: Vec<f64> = times.iter().map(|t| 2e5 * (20.0 * t).sin()).collect();
        let input = || SampledInput::new(&times, &force, Interpolation::Linear).unwrap();
        let (tableau, step) = (Tableau::rk4(), ConstantStep::new(5e-3));

        let motion = SealedMotion::<f64>::new(&model, &model.force);
        let problem = TrajectoryProblem {
            condition: motion.condition(masses),
            input: input(),
            t0: 0.0,
            t1: times[399],
            y0: vec![0.1, -1.0],
            observe_s: &times,
        };
        let one = |_: usize, states: &[f64], cotangents: &mut [f64]| loss(states, cotangents);
        let batched = BatchedIntegrator::new(tableau.clone(), step);
        let ours =
            batched.value_and_gradient(&motion, &[problem], &one, &mut BatchWorkspace::default());

        let integrator = Integrator::new(tableau, step);
        let joint = Problem {
            field: &model.sealed(masses),
            input: &Fixed(input()),
            t0: 0.0,
            t1: times[399],
            y0: &[0.1, -1.0, 400.0, 400.0],
            observations_s: &times,
            integrator: &integrator,
        };
        let mut of_motion = |_: &[f64], states: &[f64], cotangents: &mut [f64]| {
            let motion: Vec<f64> = states.chunks(4).flat_map(|y| [y[0], y[1]]).collect();
            let mut own = vec![0.0; motion.len()];
            let value = loss(&motion, &mut own);
            for (c, own) in cotangents.chunks_mut(4).zip(own.chunks(2)) {
                c[..2].copy_from_slice(own);
            }
            value
        };
        let exact =
            DiscreteAdjoint::new(ByTape).value_and_gradient(&joint, &mut of_motion).unwrap();
        let by_hand =
            DiscreteAdjoint::new(ByHand).value_and_gradient(&joint, &mut of_motion).unwrap();
        assert!(relative(&by_hand.parameters, &exact.parameters) < 1e-12, "{activation}");
        assert!(relative(&by_hand.initial_state, &exact.initial_state) < 1e-12, "{activation}");
        let n = ours.shared.len() - 2;
        assert!((ours.value - exact.value).abs() < 1e-12 * exact.value);
        assert!(relative(&ours.shared[..n], &exact.parameters[..n]) < 1e-12, "{activation}");
        let slope = model.raw.mass.sigmoid();
        assert!((ours.shared[n] * slope / exact.parameters[n] - 1.0).abs() < 1e-11);
        assert!((ours.shared[n + 1] / exact.parameters[n + 3] - 1.0).abs() < 1e-11);
        assert!(relative(&ours.own[0], &exact.parameters[n + 4..]) < 1e-11);
        assert!(relative(&ours.initial_state[0], &exact.initial_state[..2]) < 1e-11);
    }
}

/// One trajectory that runs away does not spoil the others, and tells where it stopped.
#[test]
fn a_failure_is_told_and_stays_alone() {
    let mut runs = runs();
    runs[2].y0 = vec![1e200, 1e200];
    let batched = BatchedIntegrator::new(Tableau::tsit5(), ConstantStep::new(0.05)).with_width(3);
    let gradient = in_batches(&runs, Interpolation::Linear, &batched, 2);
    assert_eq!(gradient.failures.len(), 1);
    let failure = &gradient.failures[0];
    assert_eq!((failure.problem, failure.time_s), (2, 0.1));
    assert!(matches!(failure.kind, FailureKind::NonFinite { .. }));
    assert!(gradient.values[2].is_nan() && gradient.value.is_finite());
    runs.remove(2);
    let without = in_batches(&runs, Interpolation::Linear, &batched, 1);
    assert_eq!((without.value, &without.shared), (gradient.value, &gradient.shared));

    // A request that makes no sense is refused for its own trajectory only.
    runs[0].observe = vec![0.0];
    runs[1].y0 = vec![1.0];
    let gradient = in_batches(&runs, Interpolation::Linear, &batched, 1);
    assert_eq!(gradient.failures.iter().map(|f| f.problem).collect::<Vec<_>>(), [0, 1]);
    assert!(gradient.failures.iter().all(|f| matches!(f.kind, FailureKind::Request(_))));
}

/// A trajectory without length is observed at its start, and nothing is wrong with no problems.
#[test]
fn empty_work_is_fine() {
    let mut runs = runs();
    runs.truncate(1);
    runs[0].times.truncate(1);
    runs[0].force.truncate(1);
    runs[0].observe = vec![0.1];
    let batched = BatchedIntegrator::new(Tableau::tsit5(), ConstantStep::new(0.05));
    let gradient = in_batches(&runs, Interpolation::Linear, &batched, 1);
    let mut expected = [0.0; 2];
    let value = loss(&runs[0].y0, &mut expected);
    assert_eq!((gradient.value, &gradient.initial_state[0][..]), (value, &expected[..]));

    let field = VanDerPol { mu: 1.0 };
    let none = Pointwise::like(&ByChunk::<3>.of(&field));
    let no_problems: Vec<TrajectoryProblem<'_, _, SampledInput<'_, f64>>> = Vec::new();
    let one = |_: usize, _: &[f64], _: &mut [f64]| 0.0;
    let gradient =
        batched.value_and_gradient(&none, &no_problems, &one, &mut BatchWorkspace::default());
    assert_eq!(gradient.value, 0.0);
    assert_eq!(ByTape.of(&field).parameter_len(), 1);
}
