//! Requests at the edge: nothing to observe, nothing to solve, inconsistent ones; and what gradients cost.

use super::case::loss;
use super::fields::{AnyField, Linear, VanDerPol};
use super::inputs::AnyInput;
use pam_autodiff::{ByDual, ByTape};
use pam_solvers::sensitivity::{
    Backsolve, Checkpointing, Direction, DiscreteAdjoint, DualsThroughSolver, FiniteDifference,
    ForwardSensitivity, GradientMethod, InterpolatingAdjoint, Problem, QuadratureAdjoint,
    TapeThroughSolver,
};
use pam_solvers::{
    Constant, ConstantStep, FailureKind, Integrator, Interpolation, NoInput, PidController,
    SampledInput, Tableau,
};

const SCALES: [f64; 2] = [1.0, 2.0];

fn tsit5() -> Integrator<PidController> {
    Integrator::new(Tableau::tsit5(), PidController::new(1e-6, 1e-6))
}

fn van_der_pol(inputs: usize) -> AnyField<f64> {
    VanDerPol { mu: 1.0, inputs }.into()
}

fn constant(values: &[f64]) -> AnyInput<'static, f64> {
    AnyInput::Constant(Constant(values.to_vec()))
}

fn methods() -> Vec<Box<dyn GradientMethod<AnyField<f64>, AnyInput<'static, f64>>>> {
    let adjoint = DiscreteAdjoint::new(ByTape);
    vec![
        Box::new(TapeThroughSolver),
        Box::new(DualsThroughSolver::<3>),
        Box::new(adjoint),
        Box::new(adjoint.with_checkpointing(Checkpointing::Interval(3))),
        Box::new(adjoint.with_checkpointing(Checkpointing::Binomial { snapshots: 2 })),
        Box::new(ForwardSensitivity::new(ByDual)),
        Box::new(Backsolve::new(ByDual).with_backward(tsit5())),
        Box::new(InterpolatingAdjoint::new(ByTape).with_backward(tsit5())),
        Box::new(QuadratureAdjoint::new(ByTape).with_backward(tsit5())),
        Box::new(FiniteDifference::default()),
    ]
}

#[test]
fn no_observation_has_no_gradient_and_an_observed_start_has_its_cotangent() {
    let (field, input) = (van_der_pol(1), constant(&[0.3]));
    let integrator = tsit5();
    let all = Problem {
        field: &field,
        input: &input,
        t0: 0.5,
        t1: 1.0,
        y0: &[1.0, 0.5],
        observations_s: &[],
        integrator: &integrator,
    };
    let mut sum = |_: &[f64], y: &[f64], w: &mut [f64]| {
        w.fill(3.0);
        3.0 * y.iter().sum::<f64>()
    };
    for method in methods() {
        let name = method.name();
        let nothing = method.value_and_gradient(&all, &mut sum).unwrap();
        assert_eq!(nothing.value, 0.0, "{name}");
        assert_eq!((nothing.parameters, nothing.input), (vec![0.0], vec![0.0]), "{name}");
        assert_eq!(nothing.initial_state, [0.0, 0.0], "{name}");
        for t1 in [0.5, 1.0] {
            let start = Problem { observations_s: &[0.5], t1, ..all };
            let start = method.value_and_gradient(&start, &mut sum).unwrap();
            assert_eq!(start.value, 4.5, "{name}");
            assert_eq!(start.parameters, [0.0], "{name}");
            for slope in start.initial_state {
                assert!((slope - 3.0).abs() < 1e-9, "{name}: {slope}");
            }
        }
    }
}

#[test]
fn inconsistent_requests_are_refused() {
    let (field, input) = (van_der_pol(1), constant(&[0.3]));
    let integrator = tsit5();
    let good = Problem {
        field: &field,
        input: &input,
        t0: 0.0,
        t1: 1.0,
        y0: &[1.0, 0.5],
        observations_s: &[0.5],
        integrator: &integrator,
    };
    let refused = |method: &dyn GradientMethod<_, _>, problem: &Problem<'_, _, _>, part: &str| {
        let e = method.value_and_gradient(problem, &mut loss(&SCALES)).unwrap_err();
        assert!(matches!(e.kind, FailureKind::Request(_)), "{e}");
        assert!(e.to_string().contains(part), "{e}");
    };
    for method in methods() {
        refused(&*method, &Problem { observations_s: &[0.5, 0.2], ..good }, "must increase");
        refused(&*method, &Problem { observations_s: &[1.5], ..good }, "outside");
        refused(&*method, &Problem { y0: &[1.0], ..good }, "initial state");
        refused(&*method, &Problem { input: &constant(&[]), ..good }, "inputs");
        refused(&*method, &Problem { t1: f64::NAN, ..good }, "interval");
    }
    for empty in [Checkpointing::Interval(0), Checkpointing::Binomial { snapshots: 0 }] {
        let method = DiscreteAdjoint::new(ByTape).with_checkpointing(empty);
        refused(&method, &good, "stores nothing");
    }
    let other = vec![Direction::InitialState(0), Direction::Parameter(1)];
    let method = FiniteDifference::default().with_directions(other.clone());
    refused(&method, &good, "no Parameter(1)");
    let method = ForwardSensitivity::new(ByDual).with_directions(other);
    refused(&method, &good, "no Parameter(1)");
}

/// Some directions give the same numbers as all of them.
#[test]
fn directions_can_be_chosen() {
    let (field, input) = (AnyField::from(Linear::with_inputs(1)), constant(&[0.3]));
    let integrator = tsit5();
    let problem = Problem {
        field: &field,
        input: &input,
        t0: 0.0,
        t1: 1.0,
        y0: &[1.0, 0.5],
        observations_s: &[0.5, 1.0],
        integrator: &integrator,
    };
    let some = vec![Direction::Input(0), Direction::Parameter(2), Direction::InitialState(1)];
    let check = |all: &dyn GradientMethod<_, _>, chosen: &dyn GradientMethod<_, _>| {
        let all = all.value_and_gradient(&problem, &mut loss(&SCALES)).unwrap();
        let chosen = chosen.value_and_gradient(&problem, &mut loss(&SCALES)).unwrap();
        let mut parameters = vec![0.0; 6];
        parameters[2] = all.parameters[2];
        assert_eq!(chosen.parameters, parameters);
        assert_eq!(chosen.initial_state, [0.0, all.initial_state[1]]);
        assert_eq!(chosen.input, all.input);
    };
    let forward = ForwardSensitivity::new(ByDual);
    check(&forward, &forward.clone().with_directions(some.clone()));
    let differences = FiniteDifference::default();
    check(&differences, &differences.clone().with_directions(some.clone()));
    let some = forward.with_directions(some.clone());
    assert_eq!(some.sensitivities(&problem).unwrap().directions, some.directions.unwrap());
}

/// What it costs, on a fixed problem: changes of cost show here.
#[test]
fn statistics_of_a_fixed_problem() {
    let field = AnyField::from(Linear::with_inputs(1));
    let times: Vec<f64> = (0..5).map(|k| f64::from(k) * 0.25).collect();
    let values = [1.0, 0.5, -0.5, 2.0, 0.0];
    let input = SampledInput::new(&times, &values, Interpolation::Hold).unwrap();
    let input = AnyInput::Sampled(input);
    let integrator = Integrator::new(Tableau::tsit5(), ConstantStep::new(0.05));
    let problem = Problem {
        field: &field,
        input: &input,
        t0: 0.0,
        t1: 1.0,
        y0: &[1.0, 0.0],
        // Inside a step, inside one that ends at a jump, at a jump, at the end.
        observations_s: &[0.12, 0.22, 0.5, 1.0],
        integrator: &integrator,
    };
    let adjoint = DiscreteAdjoint::new(ByTape);
    let statistics = |method: &dyn GradientMethod<_, _>| {
        method.value_and_gradient(&problem, &mut loss(&SCALES)).unwrap().statistics
    };
    let all_save = statistics(&adjoint);
    assert_eq!((all_save.steps, all_save.rejected, all_save.replayed), (20, 0, 0));
    // Six stages a step; first stages are FSAL stages of the step before. Only the observation
    // inside a step that ends at a jump needs one more.
    assert_eq!(all_save.evaluations, 20 * 6 + 1);
    assert_eq!(all_save.vjps, 20 * 6 + 1);
    assert_eq!(all_save.checkpoint_bytes, 20 * 7 * 2 * 8);
    let interval = statistics(&adjoint.with_checkpointing(Checkpointing::Interval(5)));
    assert_eq!((interval.vjps, interval.replayed), (20 * 6 + 1, 20));
    assert_eq!(interval.checkpoint_bytes, (4 * 2 + 5 * 7) * 2 * 8);
    let binomial = Checkpointing::Binomial { snapshots: 3 };
    let binomial = statistics(&adjoint.with_checkpointing(binomial));
    // β(3, 3) = 20 steps take 3 · 20 − β(4, 2) repeats, and each once more for its stages.
    assert_eq!((binomial.vjps, binomial.replayed), (20 * 6 + 1, 3 * 20 - 15 + 20));
    assert_eq!(binomial.checkpoint_bytes, 3 * 2 * 2 * 8);
    let forward = statistics(&ForwardSensitivity::new(ByTape));
    // Six parameters, two states, five samples.
    assert_eq!(forward.jvps, (6 + 2 + 5) * (20 * 6 + 1));
}

/// Forward sensitivities are also there for themselves.
#[test]
fn sensitivities_are_the_derivatives_of_the_observed_states() {
    let field = van_der_pol(0);
    let integrator = tsit5();
    let problem = Problem {
        field: &field,
        input: &AnyInput::None(NoInput),
        t0: 0.0,
        t1: 1.0,
        y0: &[1.0, 0.5],
        observations_s: &[0.0, 0.4, 1.0],
        integrator: &integrator,
    };
    let s = ForwardSensitivity::new(ByTape).sensitivities(&problem).unwrap();
    assert_eq!((s.states.len(), s.tangents.len()), (3 * 2, 3 * 3 * 2));
    assert_eq!(s.tangents[..6], [0.0, 0.0, 1.0, 0.0, 0.0, 1.0], "μ, x, v at the start");
    for k in 0..6 {
        let mut pick = |_: &[f64], y: &[f64], w: &mut [f64]| {
            w[k] = 1.0;
            y[k]
        };
        let adjoint = DiscreteAdjoint::new(ByTape);
        let gradient = adjoint.value_and_gradient(&problem, &mut pick).unwrap();
        let row: Vec<f64> = (0..3).map(|d| s.tangents[(k / 2) * 6 + d * 2 + k % 2]).collect();
        assert!((row[0] - gradient.parameters[0]).abs() < 1e-12);
        assert!((row[1] - gradient.initial_state[0]).abs() < 1e-12);
        assert!((row[2] - gradient.initial_state[1]).abs() < 1e-12);
    }
}
