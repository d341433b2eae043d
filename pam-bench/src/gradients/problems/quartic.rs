//! `u̇ = (t − θ)⁴`.

use crate::gradients::case::{Case, Exact};
use pam_core::{ParametricField, Scalar, VectorField};
use pam_solvers::NoInput;

/// Name of the problem.
pub const NAME: &str = "quartic";

/// `u̇ = (t − θ)⁴`; the parameter is θ.
///
/// Around `t = θ` the state hardly changes and steps grow; its derivative by θ, of one order less, is
/// not as flat there. Error control on the state leaves it worse than the state.
#[derive(Debug, Clone)]
pub struct Quartic<S> {
    /// θ.
    pub theta: S,
}

impl<S: Scalar> VectorField<S> for Quartic<S> {
    fn state_len(&self) -> usize {
        1
    }
    fn input_len(&self) -> usize {
        0
    }
    fn eval_into(&self, t: f64, _y: &[S], _u: &[S], dy: &mut [S], _work: &mut [S]) {
        dy[0] = (S::constant(t) - self.theta).powi(4);
    }
}

impl ParametricField for Quartic<f64> {
    type With<S: Scalar> = Quartic<S>;
    fn parameters(&self) -> Vec<f64> {
        vec![self.theta]
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> Quartic<S> {
        Quartic { theta: p[0] }
    }
}

/// From `u = 0` to `horizon_s`, whose end is the loss; θ lies at 0.45 of it. The truth is known.
#[must_use]
pub fn case(horizon_s: f64) -> Case<Quartic<f64>, NoInput> {
    let theta = 0.45 * horizon_s;
    let after = horizon_s - theta;
    let end = (after.powi(5) + theta.powi(5)) / 5.0;
    let loss = |_: &[f64], states: &[f64], cotangents: &mut [f64]| {
        cotangents[0] = 1.0;
        states[0]
    };
    Case::new(NAME, (Quartic { theta }, NoInput), &[0.0], vec![horizon_s], loss).with_exact(Exact {
        value: end,
        parameters: vec![theta.powi(4) - after.powi(4)],
        initial_state: vec![1.0],
        states: vec![end],
    })
}
