//! A damped linear oscillation.

use crate::gradients::case::{Case, evenly, half_squares};
use pam_core::{ParametricField, Scalar, VectorField};
use pam_solvers::NoInput;

/// Name of the problem.
pub const NAME: &str = "linear";

/// `ẏ = A y` with two states; the parameters are A, row by row.
#[derive(Debug, Clone)]
pub struct Linear<S> {
    /// A, row by row.
    pub a: [S; 4],
}

impl<S: Scalar> VectorField<S> for Linear<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        0
    }
    fn eval_into(&self, _t: f64, y: &[S], _u: &[S], dy: &mut [S], _work: &mut [S]) {
        let [a, b, c, d] = self.a;
        dy[0] = a * y[0] + b * y[1];
        dy[1] = c * y[0] + d * y[1];
    }
}

impl ParametricField for Linear<f64> {
    type With<S: Scalar> = Linear<S>;
    fn parameters(&self) -> Vec<f64> {
        self.a.to_vec()
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> Linear<S> {
        Linear { a: [p[0], p[1], p[2], p[3]] }
    }
}

/// The oscillation up to `horizon_s`, observed ten times, against half its start.
#[must_use]
pub fn case(horizon_s: f64) -> Case<Linear<f64>, NoInput> {
    let field = Linear { a: [-0.3, 1.7, -2.1, -0.2] };
    let loss = half_squares(|_| [0.5, 0.0], [1.0, 1.0]);
    Case::new(NAME, (field, NoInput), &[1.0, -0.4], evenly(10, horizon_s), loss)
}
