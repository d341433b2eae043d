//! The right-hand side of a solve: a vector field with its input.

use crate::input::{Input, Side};
use pam_core::{Scalar, VectorField};

/// A vector field `f(t, y, u)` and its input `u(t)`.
#[derive(Debug, Clone, Copy)]
pub struct Term<F, I> {
    /// The vector field.
    pub field: F,
    /// The input.
    pub input: I,
}

impl<F, I> Term<F, I> {
    /// Joins a field and an input; the number of inputs is checked when a solve starts.
    pub fn new(field: F, input: I) -> Self {
        Self { field, input }
    }

    /// Writes `f(t, y, u(t±))` to `dy`. `u` and `work` are scratch memory of the lengths that input
    /// and field ask for.
    #[inline]
    pub fn eval_into<S: Scalar>(
        &self,
        t: f64,
        side: Side,
        y: &[S],
        dy: &mut [S],
        u: &mut [S],
        work: &mut [S],
    ) where
        F: VectorField<S>,
        I: Input<S>,
    {
        self.input.value_into(t, side, u);
        self.field.eval_into(t, y, u, dy, work);
    }
}
