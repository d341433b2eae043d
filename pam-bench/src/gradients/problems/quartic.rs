//! `u̇ = (t − θ)⁴`.

use super::small::{Rates, SmallField};
use crate::gradients::case::{Case, Exact};
use pam_core::Scalar;
use pam_solvers::NoInput;

/// Name of the problem.
pub const NAME: &str = "quartic";

/// `u̇ = (t − θ)⁴`; the parameter is θ.
///
/// Around `t = θ` the state hardly changes and steps grow; its derivative by θ, of one order less, is
/// not as flat there. Error control on the state leaves it worse than the state.
#[inline]
pub(super) fn rates<S: Scalar>(t: f64, p: &[S], dy: &mut [S]) {
    dy[0] = (S::constant(t) - p[0]).powi(4);
}

/// From `u = 0` to `horizon_s`, whose end is the loss; θ lies at 0.45 of it. The truth is known.
#[must_use]
pub fn case(horizon_s: f64) -> Case<SmallField<f64>, NoInput> {
    let theta = 0.45 * horizon_s;
    let after = horizon_s - theta;
    let end = (after.powi(5) + theta.powi(5)) / 5.0;
    let loss = |_: &[f64], states: &[f64], cotangents: &mut [f64]| {
        cotangents[0] = 1.0;
        states[0]
    };
    let field = SmallField::new(Rates::Quartic, 1, vec![theta]);
    Case::new(NAME, (field, NoInput), &[0.0], vec![horizon_s], loss).with_exact(Exact {
        value: end,
        parameters: vec![theta.powi(4) - after.powi(4)],
        initial_state: vec![1.0],
        states: vec![end],
    })
}
