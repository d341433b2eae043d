//! Where gradients of a well-solved problem go wrong, and what tells.

use super::case::apart;
use super::fields::{AnyField, Cycle, LinearSlowFast, Quartic, SlowFast};
use super::inputs::AnyInput;
use pam_autodiff::ByTape;
use pam_solvers::sensitivity::{
    Backsolve, DiscreteAdjoint, GradientMethod, InterpolatingAdjoint, Problem, tolerance_halving,
};
use pam_solvers::{FailureKind, Integrator, NoInput, PidController, Tableau};

/// The last state's first entry.
fn last(_times: &[f64], states: &[f64], cotangents: &mut [f64]) -> f64 {
    cotangents[0] = 1.0;
    states[0]
}

fn at_end<'a>(
    field: &'a AnyField<f64>,
    y0: &'a [f64],
    t1: &'a f64,
    integrator: &'a Integrator<PidController>,
) -> Problem<'a, AnyField<f64>, AnyInput<'a, f64>> {
    Problem {
        field,
        input: &AnyInput::None(NoInput),
        t0: 0.0,
        t1: *t1,
        y0,
        observations_s: std::slice::from_ref(t1),
        integrator,
    }
}

/// `u̇ = (t − θ)⁴`: with a low-order pair the gradient has a larger relative error than the state, and the
/// halving of the tolerance shows its size.
#[test]
fn halving_the_tolerance_shows_an_unconverged_gradient() {
    let (theta, t1) = (0.9_f64, 2.0_f64);
    let field = AnyField::from(Quartic { theta });
    let exact = ((t1 - theta).powi(5) + theta.powi(5)) / 5.0;
    let exact_slope = theta.powi(4) - (t1 - theta).powi(4);
    let adjoint = DiscreteAdjoint::new(ByTape);
    for tolerance in [1e-2, 1e-3, 1e-5] {
        let integrator =
            Integrator::new(Tableau::bogacki_shampine3(), PidController::new(tolerance, tolerance));
        let problem = at_end(&field, &[0.0], &t1, &integrator);
        let halving = tolerance_halving(&adjoint, &problem, &integrator, &mut last).unwrap();
        let value_error = (halving.coarse.value / exact - 1.0).abs();
        let gradient_error = (halving.coarse.parameters[0] / exact_slope - 1.0).abs();
        let [value_moves, gradient_moves, ..] = halving.relative_difference;
        assert!(gradient_error > 1.5 * value_error);
        assert!((0.2..2.0).contains(&(gradient_moves / gradient_error)));
        println!(
            "(t − θ)⁴ at {tolerance:.0e}: errors {value_error:.1e} and {gradient_error:.1e}, \
             halving moves {value_moves:.1e} and {gradient_moves:.1e}"
        );
    }
}

/// At a rest point the state is exact with any step, so steps grow without bound; the gradient needs the
/// oscillation around the rest point and is wrong by orders of magnitude. Halving the tolerance changes
/// nothing, because no error is there to be halved: only a bound on the step helps. (P. Eberhard and
/// C. Bischof, *Automatic differentiation of numerical integration algorithms*, Mathematics of Computation
/// 68, 1999.)
#[test]
fn at_a_rest_point_the_gradient_is_wrong_and_halving_does_not_tell() {
    let (field, t1) = (AnyField::from(Cycle { a: 1.0 }), 20.0_f64);
    let adjoint = DiscreteAdjoint::new(ByTape);
    let gradient = |controller: PidController| {
        let integrator = Integrator::new(Tableau::tsit5(), controller);
        let problem = at_end(&field, &[1.0, 1.0], &t1, &integrator);
        tolerance_halving(&adjoint, &problem, &integrator, &mut last).unwrap()
    };
    // Around the rest point δ̈ = −δ, and by linearisation ∂y_1/∂a = 1 − cos t + sin t.
    let exact = 1.0 - t1.cos() + t1.sin();
    let mut bounded = PidController::new(1e-6, 1e-6);
    bounded.largest_step_s = 0.05;
    let (loose, right) = (gradient(PidController::new(1e-6, 1e-6)), gradient(bounded));
    println!(
        "rest point: exact {exact:.6}, free steps {:.3e} ({} steps), bounded {:.6}; halving {:.1e}",
        loose.coarse.parameters[0],
        loose.coarse.statistics.steps,
        right.coarse.parameters[0],
        loose.relative_difference[1],
    );
    assert_eq!(loose.coarse.value, 1.0, "the state is exact");
    assert!(loose.relative_difference[1] < 1e-3);
    assert!((right.coarse.parameters[0] / exact - 1.0).abs() < 1e-5);
    assert!((loose.coarse.parameters[0] / exact - 1.0).abs() > 0.1);
}

/// A fast decay: the discrete adjoint is right, the backsolve, which has to undo the decay, is not.
#[test]
fn backsolve_fails_on_a_stiff_problem_and_the_discrete_adjoint_does_not() {
    let field = AnyField::from(SlowFast { p: 1.0, k: 200.0 });
    let (y0, t1) = ([1.0, 1.5], 1.0);
    let tsit5 = |tolerance: f64| {
        Integrator::new(Tableau::tsit5(), PidController::new(tolerance, tolerance))
    };
    let (integrator, exact) = (tsit5(1e-7), tsit5(1e-12));
    let problem = at_end(&field, &y0, &t1, &integrator);
    let adjoint = DiscreteAdjoint::new(ByTape);
    let truth = Problem { integrator: &exact, ..problem };
    let truth = adjoint.value_and_gradient(&truth, &mut last).unwrap().parameters;
    let right = adjoint.value_and_gradient(&problem, &mut last).unwrap();
    let interpolating = InterpolatingAdjoint::new(ByTape).with_backward(tsit5(1e-7));
    let interpolating = interpolating.value_and_gradient(&problem, &mut last).unwrap();
    println!("stiff: truth {truth:?}, discrete {:?}", right.parameters);
    println!("stiff: interpolating {:?}", interpolating.parameters);
    assert!(apart(&right.parameters, &truth) < 1e-5);
    assert!(apart(&interpolating.parameters, &truth) < 1e-3);

    let backsolve = Backsolve::new(ByTape).with_backward(tsit5(1e-7).with_max_steps(20_000));
    let e = backsolve.value_and_gradient(&problem, &mut last).unwrap_err();
    println!("stiff: {e}; reached {:?}", e.state);
    assert!(matches!(e.kind, FailureKind::Backward(_)), "{e}");
    assert!((0.0..=t1).contains(&e.time_s));
    assert_eq!(e.partial.len(), 1, "what the forward solve observed");
    assert_eq!(e.state.len(), 6, "state, adjoint, parameters");

    // Where nothing nonlinear stops it, it gets through and is wrong.
    let field = AnyField::from(LinearSlowFast { p: 1.0, k: 60.0 });
    let problem = at_end(&field, &y0, &t1, &integrator);
    let right = adjoint.value_and_gradient(&problem, &mut last).unwrap();
    let wrong = backsolve.value_and_gradient(&problem, &mut last).unwrap();
    let off = apart(&wrong.parameters, &right.parameters);
    println!("stiff: {:?}, backsolve {:?}", right.parameters, wrong.parameters);
    assert!(off > 1.0, "{off}");
}
