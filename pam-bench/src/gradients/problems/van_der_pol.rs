//! Van der Pol's oscillator.

use crate::gradients::case::{Case, evenly, half_squares};
use pam_core::{ParametricField, Scalar, VectorField};
use pam_solvers::NoInput;

/// Name of the problem.
pub const NAME: &str = "van-der-pol";

/// `ẍ = μ (1 − x²) ẋ − k x`; the parameters are μ and k.
#[derive(Debug, Clone)]
pub struct VanDerPol<S> {
    /// Strength of the nonlinear damping.
    pub mu: S,
    /// Stiffness.
    pub stiffness: S,
}

impl<S: Scalar> VectorField<S> for VanDerPol<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        0
    }
    fn eval_into(&self, _t: f64, y: &[S], _u: &[S], dy: &mut [S], _work: &mut [S]) {
        dy[0] = y[1];
        dy[1] = self.mu * (S::constant(1.0) - y[0] * y[0]) * y[1] - self.stiffness * y[0];
    }
}

impl ParametricField for VanDerPol<f64> {
    type With<S: Scalar> = VanDerPol<S>;
    fn parameters(&self) -> Vec<f64> {
        vec![self.mu, self.stiffness]
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> VanDerPol<S> {
        VanDerPol { mu: p[0], stiffness: p[1] }
    }
}

/// The oscillator up to `horizon_s`, observed at every tenth of a second, against a sine.
#[must_use]
pub fn case(horizon_s: f64) -> Case<VanDerPol<f64>, NoInput> {
    let field = VanDerPol { mu: 1.5, stiffness: 1.0 };
    let loss = half_squares(|t| [2.0 * t.cos(), -2.0 * t.sin()], [1.0, 1.0]);
    let count = (horizon_s * 10.0).round().max(1.0) as usize;
    Case::new(NAME, (field, NoInput), &[2.0, 0.0], evenly(count, horizon_s), loss)
}
