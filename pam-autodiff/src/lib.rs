//! Derivatives of functions that are written against [`pam_core::Scalar`].
//!
//! - [`derivative`]: exact first derivative of a scalar function by dual numbers;
//! - [`finite_difference`]: difference schemes as values, so that they can be swapped and compared;
//! - [`stiffness`]: stiffness `∂f/∂x` and damping `∂f/∂ẋ` of a force model, exact or by a scheme.

#[macro_use]
pub mod numbers;

pub mod batch;
pub mod field;
pub mod finite_difference;
pub mod stiffness;
pub mod tape;

pub use batch::BatchField;
pub use field::{
    At, ByChunk, ByDual, ByTape, Cotangent, DifferentiableField, Differentiation, Tangent,
};
pub use finite_difference::{Central, DifferenceScheme, Forward, FourPointSmoothed};
pub use numbers::{Chunk, ComplexStep};
pub use stiffness::{
    LinearForce, damping_exact_kg_s, linearise, stiffness_by_difference_n_mm, stiffness_exact_n_mm,
};
pub use tape::{Tape, Var};

use num_dual::Dual64;

/// `f'(x)` by one dual-number evaluation, exact to rounding. At a kink it is the derivative of the
/// branch that `f` takes there.
///
/// ```
/// use pam_core::Scalar;
/// let d = pam_autodiff::derivative(|x| x * x * x, 2.0);
/// assert_eq!(d, 12.0);
/// ```
pub fn derivative(f: impl FnOnce(Dual64) -> Dual64, x: f64) -> f64 {
    f(Dual64::new(x, 1.0)).eps
}
