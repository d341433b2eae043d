//! Vector fields with their derivatives.
//!
//! Sensitivity methods need a [`DifferentiableField`]: the products of its Jacobians with vectors from
//! either side. A [`Differentiation`] makes one from a field: by a tape ([`ByTape`]), by dual numbers
//! ([`ByDual`]), or by hand-written VJPs ([`ByHand`]). Any method works with any differentiation.

mod dual;
mod hand;
mod tape;

pub use dual::{ByChunk, ByDual, DualField, DualWorkspace};
pub use hand::{ByHand, HandJoint, HandWorkspace};
pub use tape::{ByTape, TapeWorkspace, TapedField};

/// Where a field is evaluated: time (s), state and input.
#[derive(Debug, Clone, Copy)]
pub struct At<'a> {
    /// Time, s.
    pub t: f64,
    /// State y.
    pub y: &'a [f64],
    /// Input u.
    pub u: &'a [f64],
}

/// A direction of change of state, input and parameters.
#[derive(Debug, Clone, Copy)]
pub struct Tangent<'a> {
    /// Change of the state.
    pub y: &'a [f64],
    /// Change of the input.
    pub u: &'a [f64],
    /// Change of the parameters.
    pub p: &'a [f64],
}

/// Sums into which cotangents of state, input and parameters are *added*.
#[derive(Debug)]
pub struct Cotangent<'a> {
    /// Cotangent of the state.
    pub y: &'a mut [f64],
    /// Cotangent of the input.
    pub u: &'a mut [f64],
    /// Cotangent of the parameters.
    pub p: &'a mut [f64],
}

/// A vector field `f(t, y, u; p)` with the products of its Jacobians.
///
/// Every method takes the field's own scratch memory and allocates nothing once that memory is warm.
pub trait DifferentiableField {
    /// Scratch memory.
    type Workspace;

    /// Number of states.
    fn state_len(&self) -> usize;

    /// Number of inputs.
    fn input_len(&self) -> usize;

    /// Number of parameters.
    fn parameter_len(&self) -> usize;

    /// Scratch memory for the other methods.
    fn workspace(&self) -> Self::Workspace;

    /// Writes `f` to `dy`.
    fn eval_into(&self, at: At<'_>, dy: &mut [f64], work: &mut Self::Workspace);

    /// Adds `(∂f/∂y)ᵀ w`, `(∂f/∂u)ᵀ w` and `(∂f/∂p)ᵀ w` to `sums`, for the cotangent `w` of `f`.
    fn vjp_into(&self, at: At<'_>, w: &[f64], sums: Cotangent<'_>, work: &mut Self::Workspace);

    /// Writes `∂f/∂y · v.y + ∂f/∂u · v.u + ∂f/∂p · v.p` to `dy`.
    fn jvp_into(&self, at: At<'_>, v: Tangent<'_>, dy: &mut [f64], work: &mut Self::Workspace);
}

/// A way to differentiate fields of type `F`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not differentiate the field `{F}`",
    note = "`ByTape` and `ByDual` differentiate every `ParametricField`, `ByHand` the joint with a network"
)]
pub trait Differentiation<F> {
    /// The field with its derivatives.
    type Field<'a>: DifferentiableField
    where
        F: 'a,
        Self: 'a;

    /// Name for tables and figures.
    fn name(&self) -> &'static str;

    /// `field` with its derivatives.
    fn of<'a>(&'a self, field: &'a F) -> Self::Field<'a>;
}
