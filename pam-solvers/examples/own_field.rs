//! A vector field, an input and a loss of one's own, as closures and as types.

use pam_autodiff::ByTape;
use pam_core::{FieldFn, ParametricField, Scalar, VectorField};
use pam_solvers::sensitivity::{DiscreteAdjoint, GradientMethod, Problem};
use pam_solvers::{InputFn, Integrator, PidController, SaveAt, SolveError, Tableau, Term};

/// A driven pendulum, `φ̈ = −ω² sin φ − d φ̇ + u`, in rad and s.
struct Pendulum<S> {
    omega_squared: S,
    damping: S,
}

impl<S: Scalar> VectorField<S> for Pendulum<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        1
    }
    fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
        dy[0] = y[1];
        dy[1] = u[0] - self.omega_squared * y[0].sin() - self.damping * y[1];
    }
}

/// With exchangeable numbers every gradient method applies.
impl ParametricField for Pendulum<f64> {
    type With<S: Scalar> = Pendulum<S>;
    fn parameters(&self) -> Vec<f64> {
        vec![self.omega_squared, self.damping]
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> Pendulum<S> {
        Pendulum { omega_squared: p[0], damping: p[1] }
    }
}

fn main() -> Result<(), Box<SolveError<f64>>> {
    let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-10, 1e-10));
    let drive = InputFn::new(1, |t: f64, u: &mut [f64]| u[0] = 0.5 * (1.3 * t).sin());

    // The quickest way: closures for field and input.
    let by_closure = FieldFn::new(2, 1, |_t, y: &[f64], u: &[f64], dy: &mut [f64]| {
        dy[0] = y[1];
        dy[1] = u[0] - 9.0 * y[0].sin() - 0.2 * y[1];
    });
    let times_s: Vec<f64> = (0..=50).map(|k| 0.1 * f64::from(k)).collect();
    let closure_run = integrator.solve(
        &Term::new(by_closure, drive),
        0.0,
        5.0,
        &[0.3, 0.0],
        SaveAt::Times(&times_s),
    )?;

    // The same as a type.
    let pendulum = Pendulum { omega_squared: 9.0, damping: 0.2 };
    let typed_run = integrator.solve(
        &Term::new(&pendulum, drive),
        0.0,
        5.0,
        &[0.3, 0.0],
        SaveAt::Times(&times_s),
    )?;
    assert_eq!(closure_run.states(), typed_run.states());

    // Any loss that gives its slopes by the states: here a closure, the mean square of the angle.
    let mut loss = |_times: &[f64], states: &[f64], cotangents: &mut [f64]| {
        let share = 2.0 / states.len() as f64;
        for (w, y) in cotangents.chunks_exact_mut(2).zip(states.chunks_exact(2)) {
            w[0] = 2.0 * share * y[0];
        }
        states.chunks_exact(2).map(|y| share * y[0] * y[0]).sum::<f64>()
    };
    let problem = Problem {
        field: &pendulum,
        input: &drive,
        t0: 0.0,
        t1: 5.0,
        y0: &[0.3, 0.0],
        observations_s: &times_s,
        integrator: &integrator,
    };
    let method = DiscreteAdjoint::new(ByTape);
    let g = method.value_and_gradient(&problem, &mut loss)?;
    println!("L = {:.6}, dL/dω² = {:.6}, dL/dd = {:.6}", g.value, g.parameters[0], g.parameters[1]);

    // It is the slope: a difference of two solves agrees.
    let mut value = |damping: f64| {
        let other = Pendulum { omega_squared: 9.0, damping };
        method.value_and_gradient(&Problem { field: &other, ..problem }, &mut loss).map(|g| g.value)
    };
    let difference = (value(0.2 + 1e-4)? - value(0.2 - 1e-4)?) / 2e-4;
    assert!((g.parameters[1] - difference).abs() < 1e-6, "{} {difference}", g.parameters[1]);
    Ok(())
}
