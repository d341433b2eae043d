//! How a whole trajectory changes with parameters and initial state: forward sensitivities.

use pam_autodiff::ByDual;
use pam_core::{ParametricField, Scalar, VectorField};
use pam_solvers::sensitivity::{Direction, ForwardSensitivity, Problem};
use pam_solvers::{Integrator, NoInput, PidController, SolveError, Tableau};

/// Exponential decay to a level, `ẏ = −r (y − l)`.
struct Decay<S> {
    rate: S,
    level: S,
}

impl<S: Scalar> VectorField<S> for Decay<S> {
    fn state_len(&self) -> usize {
        1
    }
    fn input_len(&self) -> usize {
        0
    }
    fn eval_into(&self, _t: f64, y: &[S], _u: &[S], dy: &mut [S], _work: &mut [S]) {
        dy[0] = -self.rate * (y[0] - self.level);
    }
}

impl ParametricField for Decay<f64> {
    type With<S: Scalar> = Decay<S>;
    fn parameters(&self) -> Vec<f64> {
        vec![self.rate, self.level]
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> Decay<S> {
        Decay { rate: p[0], level: p[1] }
    }
}

fn main() -> Result<(), Box<SolveError<f64>>> {
    let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-10, 1e-10));
    let times_s = [0.5, 1.0, 2.0];
    let problem = Problem {
        field: &Decay { rate: 1.5, level: 2.0 },
        input: &NoInput,
        t0: 0.0,
        t1: 2.0,
        y0: &[5.0],
        observations_s: &times_s,
        integrator: &integrator,
    };
    let wanted = vec![Direction::Parameter(0), Direction::Parameter(1), Direction::InitialState(0)];
    let s = ForwardSensitivity::new(ByDual).with_directions(wanted).sensitivities(&problem)?;

    // y = l + (y₀ − l) e^{−rt}
    for (k, t) in times_s.iter().enumerate() {
        let decay = (-1.5 * t).exp();
        let exact = [-3.0 * t * decay, 1.0 - decay, decay];
        println!(
            "t = {t} s: y = {:.6}, dy/d(r, l, y0) = {:.6?}",
            s.states[k],
            &s.tangents[3 * k..3 * k + 3]
        );
        for (tangent, exact) in s.tangents[3 * k..].iter().zip(exact) {
            assert!((tangent - exact).abs() < 1e-8);
        }
    }
    Ok(())
}
