//! Derivatives of functions and fields that are written against [`pam_core::Scalar`].
//!
//! Numbers that carry derivatives:
//!
//! - [`numbers`]: [`Chunk`], forward mode for several directions at once, and [`ComplexStep`];
//!   `num-dual` brings dual and hyper-dual numbers;
//! - [`tape`]: [`Tape`] and [`Var`], reverse mode.
//!
//! Derivatives of functions and fields:
//!
//! - [`drivers`]: derivative, gradient, Jacobian, products with Jacobian and Hessian, of functions;
//! - [`field`]: vector fields with the products of their Jacobians, by tape ([`ByTape`]), by dual
//!   numbers ([`ByDual`]), or by hand-written VJPs ([`ByHand`]);
//! - [`batch`]: hand-written VJPs of many points at once;
//! - [`stiffness`]: stiffness `∂f/∂x` and damping `∂f/∂ẋ` of a force model, exact or by a scheme.
//!
//! Approximations: [`finite_difference`], with schemes as values that can be exchanged and compared.

#[macro_use]
pub mod numbers;

pub mod batch;
pub mod drivers;
pub mod field;
pub mod finite_difference;
pub mod stiffness;
pub mod tape;

pub use batch::BatchField;
pub use drivers::{
    CHUNK, Function, Point, Recorder, derivative, gradient, gradient_into, gradient_of, hessian,
    hessian_vector, hessian_vector_into, jacobian_forward, jacobian_forward_into, jacobian_reverse,
    jacobian_reverse_into, jvp, jvp_into, vjp, vjp_into,
};
pub use field::{
    At, ByChunk, ByDual, ByHand, ByTape, Cotangent, DifferentiableField, Differentiation, Tangent,
};
pub use finite_difference::{
    Central, ComplexDifference, DifferenceScheme, Forward, FourPointSmoothed, Richardson,
    gradient_by_difference, scaled_gradient_by_difference,
};
pub use numbers::{Chunk, ComplexStep};
pub use stiffness::{
    LinearForce, damping_exact_kg_s, linearise, stiffness_by_difference_n_mm, stiffness_exact_n_mm,
};
pub use tape::{Gathered, Tape, Var};
