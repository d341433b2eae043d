//! A slow state with a fast one that follows it.

use super::small::{Rates, SmallField};
use crate::gradients::case::{Case, evenly, half_squares};
use pam_core::Scalar;
use pam_solvers::NoInput;

/// Name of the problem.
pub const NAME: &str = "stiff";

/// `ẋ = −p x z`, `ż = k (x − z)`; the parameters are p and k.
///
/// Going back in time the fast state explodes as `e^(k t)`: a state that is integrated back is lost after
/// `ln(1/ε)/k`, and the nonlinear coupling takes the slow one with it.
#[inline]
pub(super) fn rates<S: Scalar>(y: &[S], p: &[S], dy: &mut [S]) {
    let (slow, fast) = (p[0], p[1]);
    dy[0] = -slow * y[0] * y[1];
    dy[1] = fast * (y[0] - y[1]);
}

/// Rate of the fast state, 1/s.
pub const FAST: f64 = 200.0;

/// Up to `horizon_s`, observed twice.
#[must_use]
pub fn case(horizon_s: f64) -> Case<SmallField<f64>, NoInput> {
    let field = SmallField::new(Rates::Stiff, 2, vec![1.0, FAST]);
    let loss = half_squares(|_| [0.2, 0.2], [1.0, 1.0]);
    Case::new(NAME, (field, NoInput), &[1.0, 1.5], evenly(2, horizon_s), loss)
}
