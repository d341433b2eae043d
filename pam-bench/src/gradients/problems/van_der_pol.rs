//! Van der Pol's oscillator.

use super::small::{Rates, SmallField};
use crate::gradients::case::{Case, evenly, half_squares};
use pam_core::Scalar;
use pam_solvers::NoInput;

/// Name of the problem.
pub const NAME: &str = "van-der-pol";

/// `ẍ = μ (1 − x²) ẋ − k x`; the parameters are μ and k.
#[inline]
pub(super) fn rates<S: Scalar>(y: &[S], p: &[S], dy: &mut [S]) {
    let (mu, stiffness) = (p[0], p[1]);
    dy[0] = y[1];
    dy[1] = mu * (S::constant(1.0) - y[0] * y[0]) * y[1] - stiffness * y[0];
}

/// The oscillator up to `horizon_s`, observed at every tenth of a second, against a sine.
#[must_use]
pub fn case(horizon_s: f64) -> Case<SmallField<f64>, NoInput> {
    let field = SmallField::new(Rates::VanDerPol, 2, vec![1.5, 1.0]);
    let loss = half_squares(|t| [2.0 * t.cos(), -2.0 * t.sin()], [1.0, 1.0]);
    let count = (horizon_s * 10.0).round().max(1.0) as usize;
    Case::new(NAME, (field, NoInput), &[2.0, 0.0], evenly(count, horizon_s), loss)
}
