//! Typed failures with the partial trajectory.

use pam_core::{FieldFn, VectorField};
use pam_solvers::{
    Constant, ConstantStep, FailureKind, Integrator, NoInput, PidController, SaveAt, SolveError,
    StepBudget, Tableau, Term, Tolerances,
};

/// `y' = y²` from 1 escapes to infinity at t = 1.
fn escaping() -> Term<impl VectorField<f64>, NoInput> {
    Term::new(
        FieldFn::new(1, 0, |_t, y: &[f64], _u: &[f64], dy: &mut [f64]| dy[0] = y[0] * y[0]),
        NoInput,
    )
}

fn error_of(result: Result<pam_solvers::Solution<f64>, Box<SolveError<f64>>>) -> SolveError<f64> {
    *result.expect_err("the solve must fail")
}

#[test]
fn an_escape_returns_the_time_and_what_was_reached() {
    let times: Vec<f64> = (0..=200).map(|k| f64::from(k) * 0.01).collect();
    let adaptive = Integrator::new(Tableau::tsit5(), PidController::new(1e-8, 1e-8));
    let e = error_of(adaptive.solve(&escaping(), 0.0, 2.0, &[1.0], SaveAt::Times(&times)));
    assert!(
        matches!(e.kind, FailureKind::StepTooSmall { .. } | FailureKind::NonFinite { .. }),
        "{e}"
    );
    assert!((e.time_s - 1.0).abs() < 1e-6, "{}", e.time_s);
    assert!(e.partial.len() >= 100);
    assert!((e.partial.state(50)[0] - 2.0).abs() < 1e-6);

    let constant = Integrator::new(Tableau::rk4(), ConstantStep::new(0.01));
    let e = error_of(constant.solve(&escaping(), 0.0, 2.0, &[1.0], SaveAt::Times(&times)));
    assert!(matches!(e.kind, FailureKind::NonFinite { .. }), "{e}");
    assert!(e.state[0].is_finite() && e.partial.len() >= 100);
    assert!(e.to_string().contains("t = 1."), "{e}");
}

#[test]
fn too_many_steps_are_reported() {
    let solver = Integrator::new(Tableau::tsit5(), ConstantStep::new(1e-3)).with_max_steps(100);
    let e = error_of(solver.solve(&escaping(), 0.0, 0.5, &[1.0], SaveAt::Steps));
    assert_eq!(e.kind, FailureKind::TooManySteps { limit: 100 });
    assert_eq!(e.partial.len(), 101);
    assert!((e.time_s - 0.1).abs() < 1e-12);
}

#[test]
fn inconsistent_requests_are_refused_before_anything_runs() {
    let request = |e: SolveError<f64>| match e.kind {
        FailureKind::Request(why) => why,
        other => panic!("{other:?}"),
    };
    let rk4 = Integrator::new(Tableau::rk4(), PidController::new(1e-6, 1e-6));
    assert!(
        request(error_of(rk4.solve(&escaping(), 0.0, 1.0, &[1.0], SaveAt::End))).contains("rk4")
    );
    let solver = Integrator::new(Tableau::tsit5(), ConstantStep::new(0.1));
    let why = request(error_of(solver.solve(&escaping(), 0.0, 1.0, &[1.0, 2.0], SaveAt::End)));
    assert!(why.contains("1 states") && why.contains('2'), "{why}");
    let why = request(error_of(solver.solve(&escaping(), 1.0, 0.0, &[1.0], SaveAt::End)));
    assert!(why.contains("interval"), "{why}");
    let outside = [0.5, 3.0];
    let why =
        request(error_of(solver.solve(&escaping(), 0.0, 1.0, &[1.0], SaveAt::Times(&outside))));
    assert!(why.contains("outside"), "{why}");
    let why = request(error_of(solver.solve(&escaping(), 0.0, 1.0, &[f64::NAN], SaveAt::End)));
    assert!(why.contains("NaN"), "{why}");
    let zero = Integrator::new(Tableau::tsit5(), ConstantStep::new(0.0));
    assert!(
        request(error_of(zero.solve(&escaping(), 0.0, 1.0, &[1.0], SaveAt::End))).contains("step")
    );
    let per_state = PidController::with_tolerances(Tolerances::per_state(1e-6, vec![1e-6; 3]));
    let wrong = Integrator::new(Tableau::tsit5(), per_state);
    let why = request(error_of(wrong.solve(&escaping(), 0.0, 1.0, &[1.0], SaveAt::End)));
    assert!(why.contains("each state"), "{why}");
}

/// Costs are part of the contract: counts of a fixed problem, so that a silent change shows.
#[test]
fn statistics_of_a_fixed_problem() {
    let decay = FieldFn::new(1, 0, |_t, y: &[f64], _u: &[f64], dy: &mut [f64]| dy[0] = -y[0]);
    let term = Term::new(decay, NoInput);
    let solver = Integrator::new(Tableau::tsit5(), ConstantStep::new(0.1));
    let s = solver.solve(&term, 0.0, 1.0, &[1.0], SaveAt::End).unwrap();
    // First same as last: one evaluation to start, six a step, none to close the last step.
    assert_eq!((s.statistics.accepted, s.statistics.evaluations), (10, 1 + 9 * 6 + 5));
    let adaptive = Integrator::new(Tableau::tsit5(), PidController::new(1e-6, 1e-6));
    let s = adaptive.solve(&term, 0.0, 10.0, &[1.0], SaveAt::End).unwrap().statistics;
    assert_eq!(s.evaluations, 2 + 6 * (s.accepted + s.rejected));
    assert_eq!((s.accepted, s.rejected), (24, 0));
}

/// Stops given by the user end steps there, without disturbing the solution.
#[test]
fn stops_end_steps() {
    let decay = FieldFn::new(1, 0, |_t, y: &[f64], _u: &[f64], dy: &mut [f64]| dy[0] = -y[0]);
    let solver = Integrator::new(Tableau::tsit5(), PidController::new(1e-8, 1e-8))
        .with_stops(&[0.77, 0.123, 5.0, -1.0]);
    let s = solver.solve(&Term::new(decay, NoInput), 0.0, 1.0, &[1.0], SaveAt::Steps).unwrap();
    assert!(s.times_s().contains(&0.123) && s.times_s().contains(&0.77));
    assert!((s.last().unwrap()[0] - (-1.0_f64).exp()).abs() < 1e-8);
}

/// `ẏ = −10⁹ y` asks explicit steps of 3 ns: a second would take 3·10⁸ of them. The budget ends it after some thousands,
/// and leaves a problem alone that is stiff for a moment.
#[test]
fn a_budget_ends_steps_that_lead_nowhere() {
    struct Decay(f64);
    impl VectorField<f64> for Decay {
        fn state_len(&self) -> usize {
            1
        }
        fn input_len(&self) -> usize {
            0
        }
        fn eval_into(&self, t: f64, y: &[f64], _: &[f64], dy: &mut [f64], _: &mut [f64]) {
            // Stiff in the first microsecond, or always.
            let rate = if self.0 > 0.0 && t > self.0 { 1.0 } else { 1e9 };
            dy[0] = -rate * (y[0] - 1.0);
        }
    }
    let budget = StepBudget { per_s: 1e3, burst: 5_000, per_sample: 10, least: 1_000 };
    let solver =
        Integrator::new(Tableau::tsit5(), PidController::new(1e-6, 1e-6)).with_step_budget(budget);
    let run = |until: f64| {
        let term = Term::new(Decay(until), Constant(vec![]));
        solver.solve(&term, 0.0, 1.0, &[0.0], SaveAt::End)
    };
    let e = run(0.0).unwrap_err();
    assert!(matches!(e.kind, FailureKind::TooManySteps { limit: 5_000..5_010 }), "{:?}", e.kind);
    assert!(e.time_s > 0.0 && e.time_s < 1e-3);
    assert!(run(1e-6).is_ok());
    // By length, but never less than the least nor more than the samples give.
    assert_eq!(budget.steps(10.0, 10_000), 15_000);
    assert_eq!(budget.steps(1e12, 100), 2_000);
    assert_eq!(StepBudget { burst: 0, ..budget }.steps(1e-9, 2), 1_000);
    assert_eq!(budget.steps(f64::NAN, 2), 1_020);
}
