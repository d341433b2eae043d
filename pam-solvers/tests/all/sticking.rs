//! Dry friction against motions in closed form: stopping, turning, breaking away, and their derivatives.

use pam_autodiff::Chunk;
use pam_core::{DryFriction, Scalar, VectorField};
use pam_solvers::{
    Constant, FailureKind, InputFn, Integrator, Interpolation, PidController, SampledInput,
    Tableau, Term,
};

/// `v̇ = u − c (σ + a |σ|)`: position, velocity.
struct Sledge<S> {
    friction: S,
    asymmetry: S,
}

impl<S: Scalar> VectorField<S> for Sledge<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        2
    }
    fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
        dy[0] = y[1];
        dy[1] = u[0] - self.friction * (u[1] + self.asymmetry.scaled(u[1].real().abs()));
    }
}

const FRICTION: DryFriction = DryFriction { velocity: 1, direction: 1 };

fn integrator() -> Integrator<PidController> {
    Integrator::new(Tableau::tsit5(), PidController::new(1e-9, 1e-9))
}

/// The state at the end, by friction (direction 0) and initial velocity (direction 1).
fn slid(push: f64, velocity: f64, friction: f64, asymmetry: f64, end_s: f64) -> [Chunk<2>; 2] {
    let sledge =
        Sledge { friction: Chunk::variable(friction, 0), asymmetry: Chunk::constant(asymmetry) };
    let input = Constant(vec![Chunk::constant(push)]);
    let y0 = [Chunk::constant(0.0), Chunk::variable(velocity, 1)];
    let times = [0.0, 0.37 * end_s, end_s];
    let run = integrator().solve_sticking(&Term::new(sledge, input), FRICTION, &y0, &times);
    let run = run.expect("a run");
    [run.state(2)[0], run.state(2)[1]]
}

fn close(found: f64, exact: f64) {
    assert!((found - exact).abs() < 1e-9 * exact.abs().max(1.0), "{found} beside {exact}");
}

/// It stops after `v₀²/2c` and stays there.
#[test]
fn a_sliding_body_stops_where_its_energy_is_used_up() {
    let (v0, c) = (1.5, 0.7);
    let [x, v] = slid(0.0, v0, c, 0.0, 5.0);
    close(x.value, v0 * v0 / (2.0 * c));
    close(x.derivatives[0], -v0 * v0 / (2.0 * c * c));
    close(x.derivatives[1], v0 / c);
    assert_eq!((v.value, v.derivatives), (0.0, [0.0; 2]));
}

/// Pushed back with more than friction holds, it turns: `v̇ = −F − c`, then `−F + c`.
#[test]
fn a_body_that_is_pushed_back_turns() {
    let (f, v0, c, end) = (2.0, 1.5, 0.7, 3.0);
    let turn = v0 / (f + c);
    let left = end - turn;
    let [x, v] = slid(-f, v0, c, 0.0, end);
    close(x.value, v0 * v0 / (2.0 * (f + c)) - 0.5 * (f - c) * left * left);
    close(v.value, -(f - c) * left);
    let by_c = -v0 / (f + c).powi(2);
    close(v.derivatives[0], left + (f - c) * by_c);
    close(v.derivatives[1], (f - c) / (f + c));
    let x_by_c = -v0 * v0 / (2.0 * (f + c).powi(2)) + 0.5 * left * left + (f - c) * left * by_c;
    close(x.derivatives[0], x_by_c);
}

/// Friction that is larger forwards than backwards: 1.2 c and 0.8 c.
#[test]
fn friction_may_depend_on_the_direction() {
    let (v0, c, end) = (1.0, 1.0, 5.0);
    close(slid(0.0, v0, c, 0.2, end)[0].value, v0 * v0 / (2.0 * 1.2));
    close(slid(0.0, -v0, c, 0.2, end)[0].value, -v0 * v0 / (2.0 * 0.8));
    // A push of 0.9 c is held forwards and not backwards.
    assert_eq!(slid(0.9, 0.0, c, 0.2, end)[0].value, 0.0);
    close(slid(-0.9, 0.0, c, 0.2, end)[0].value, -0.5 * 0.1 * end * end);
}

/// Under `A sin t` it rests until `t₀ = asin(c/A)`; then `v = A (cos t₀ − cos t) − c (t − t₀)`, and `∂v/∂c = −(t − t₀)`
/// since it breaks away without acceleration.
#[test]
fn it_breaks_away_where_the_push_exceeds_friction() {
    let (a, c, end) = (2.0, 1.3, 2.0);
    let sledge = Sledge { friction: Chunk::<1>::variable(c, 0), asymmetry: Chunk::constant(0.0) };
    let push = InputFn::new(1, move |t: f64, u: &mut [Chunk<1>]| {
        u[0] = Chunk::constant(a * t.sin());
    });
    let y0 = [Chunk::constant(0.0); 2];
    let from = (c / a).asin();
    let times = [0.0, 0.99 * from, end];
    let run = integrator().solve_sticking(&Term::new(sledge, push), FRICTION, &y0, &times);
    let run = run.expect("a run");
    assert_eq!((run.state(1)[0].value, run.state(1)[1].value), (0.0, 0.0));
    let v = run.state(2)[1];
    assert!((v.value - (a * (from.cos() - end.cos()) - c * (end - from))).abs() < 1e-8);
    assert!((v.derivatives[0] + (end - from)).abs() < 1e-6, "{v:?}");
}

/// Held pushes below friction for a long time: not the last bit of the position changes (a smoothed sign would creep).
#[test]
fn it_holds_still_under_changing_pushes() {
    let times: Vec<f64> = (0..2000).map(|k| 0.01 * f64::from(k)).collect();
    let values: Vec<f64> = times.iter().map(|t| 0.99 * (7.0 * t).sin()).collect();
    let input =
        SampledInput::owned(times.clone(), values, 1, Interpolation::Hold).expect("samples");
    let sledge = Sledge { friction: 1.0, asymmetry: 0.0 };
    let run = integrator()
        .solve_sticking(&Term::new(sledge, input), FRICTION, &[0.25, 0.0], &times)
        .expect("a run");
    assert!((0..times.len()).all(|k| run.state(k) == [0.25, 0.0]));
}

/// Without friction nothing sticks: `x = sin t`, whose velocity passes zero again and again.
#[test]
fn without_friction_it_is_the_smooth_field() {
    let free = Sledge { friction: 0.0, asymmetry: 0.0 };
    let input = InputFn::new(1, |t: f64, u: &mut [f64]| u[0] = -t.sin());
    let times: Vec<f64> = (0..200).map(|k| 0.05 * f64::from(k)).collect();
    let run = integrator()
        .solve_sticking(&Term::new(free, input), FRICTION, &[0.0, 1.0], &times)
        .expect("a run");
    for (k, t) in times.iter().enumerate() {
        assert!((run.state(k)[0] - t.sin()).abs() < 1e-7, "{t}");
    }
}

#[test]
fn friction_that_does_not_fit_the_field_is_refused() {
    let sledge = Sledge { friction: 1.0, asymmetry: 0.0 };
    let input = Constant(vec![0.0]);
    let bad = DryFriction { velocity: 2, direction: 1 };
    let refused =
        integrator().solve_sticking(&Term::new(sledge, input), bad, &[0.0, 0.0], &[0.0, 1.0]);
    let error = refused.expect_err("state 2 does not exist");
    assert!(matches!(error.kind, FailureKind::Request(_)), "{error}");
}
