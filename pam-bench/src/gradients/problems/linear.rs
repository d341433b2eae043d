//! A damped linear oscillation.

use super::small::{Rates, SmallField};
use crate::gradients::case::{Case, evenly, half_squares};
use pam_core::Scalar;
use pam_solvers::NoInput;

/// Name of the problem.
pub const NAME: &str = "linear";

/// `ẏ = A y` with two states; the parameters are A, row by row.
#[inline]
pub(super) fn rates<S: Scalar>(y: &[S], a: &[S], dy: &mut [S]) {
    dy[0] = a[0] * y[0] + a[1] * y[1];
    dy[1] = a[2] * y[0] + a[3] * y[1];
}

/// The oscillation up to `horizon_s`, observed ten times, against half its start.
#[must_use]
pub fn case(horizon_s: f64) -> Case<SmallField<f64>, NoInput> {
    let field = SmallField::new(Rates::Linear, 2, vec![-0.3, 1.7, -2.1, -0.2]);
    let loss = half_squares(|_| [0.5, 0.0], [1.0, 1.0]);
    Case::new(NAME, (field, NoInput), &[1.0, -0.4], evenly(10, horizon_s), loss)
}
