//! A slow state with a fast one that follows it.

use crate::gradients::case::{Case, evenly, half_squares};
use pam_core::{ParametricField, Scalar, VectorField};
use pam_solvers::NoInput;

/// Name of the problem.
pub const NAME: &str = "stiff";

/// `ẋ = −p x z`, `ż = k (x − z)`; the parameters are p and k.
///
/// Going back in time the fast state explodes as `e^(k t)`: a state that is integrated back is lost after
/// `ln(1/ε)/k`, and the nonlinear coupling takes the slow one with it.
#[derive(Debug, Clone)]
pub struct SlowFast<S> {
    /// Rate of the slow state.
    pub slow: S,
    /// Rate of the fast state.
    pub fast: S,
}

impl<S: Scalar> VectorField<S> for SlowFast<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        0
    }
    fn eval_into(&self, _t: f64, y: &[S], _u: &[S], dy: &mut [S], _work: &mut [S]) {
        dy[0] = -self.slow * y[0] * y[1];
        dy[1] = self.fast * (y[0] - y[1]);
    }
}

impl ParametricField for SlowFast<f64> {
    type With<S: Scalar> = SlowFast<S>;
    fn parameters(&self) -> Vec<f64> {
        vec![self.slow, self.fast]
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> SlowFast<S> {
        SlowFast { slow: p[0], fast: p[1] }
    }
}

/// Rate of the fast state, 1/s.
pub const FAST: f64 = 200.0;

/// Up to `horizon_s`, observed twice.
#[must_use]
pub fn case(horizon_s: f64) -> Case<SlowFast<f64>, NoInput> {
    let field = SlowFast { slow: 1.0, fast: FAST };
    let loss = half_squares(|_| [0.2, 0.2], [1.0, 1.0]);
    Case::new(NAME, (field, NoInput), &[1.0, 1.5], evenly(2, horizon_s), loss)
}
