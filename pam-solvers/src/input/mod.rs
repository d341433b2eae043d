//! Inputs of a vector field.

mod fixed;
mod force_signal;
mod parametric;
mod sampled;
mod simple;

pub use fixed::Fixed;
pub use force_signal::ForceSignal;
pub use parametric::ParametricInput;
pub use sampled::{InputError, Interpolation, SampledInput};
pub use simple::{Constant, InputFn, LiftedInputFn, NoInput};

use pam_core::Scalar;

/// From which side a time is approached; it matters only where an input jumps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The value just before: what the last stage of a step needs.
    Left,
    /// The value just after: what the first stage of a step needs.
    Right,
}

/// An input `u(t)`.
///
/// ```
/// use pam_solvers::{Constant, Input, InputFn, NoInput, Side};
///
/// let sine = InputFn::new(1, |t: f64, u: &mut [f64]| u[0] = 100.0 * t.sin());
/// let mut u = [0.0_f64];
/// sine.value_into(0.5, Side::Right, &mut u);
/// assert_eq!(u, [100.0 * 0.5_f64.sin()]);
/// Constant(vec![3.0]).value_into(0.5, Side::Right, &mut u);
/// assert_eq!(u, [3.0]);
/// assert_eq!(Input::<f64>::input_len(&NoInput), 0);
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no input over `{S}`",
    label = "an input is needed here",
    note = "use `NoInput`, `Constant(vec![…])`, `SampledInput`, or wrap a closure: \
            `InputFn::new(inputs, |t: f64, u: &mut [f64]| …)`"
)]
pub trait Input<S: Scalar> {
    /// Number of input variables.
    fn input_len(&self) -> usize;

    /// Writes `u(t)`, approached from `side`, to `out`.
    fn value_into(&self, t: f64, side: Side, out: &mut [S]);

    /// The first time after `t` at which the input jumps, if any. A step ends there, and
    /// the next one restarts.
    fn next_jump(&self, t: f64) -> Option<f64> {
        let _ = t;
        None
    }
}

impl<S: Scalar, I: Input<S> + ?Sized> Input<S> for &I {
    fn input_len(&self) -> usize {
        (**self).input_len()
    }
    fn value_into(&self, t: f64, side: Side, out: &mut [S]) {
        (**self).value_into(t, side, out);
    }
    fn next_jump(&self, t: f64) -> Option<f64> {
        (**self).next_jump(t)
    }
}
