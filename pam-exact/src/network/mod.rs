//! (Leaky) ReLU networks as piecewise-affine functions on a plane.
//!
//! Two inputs of the force network `(m_f, m_e, x, ẋ) → f` vary, the coordinates `(p, r)` of a [`Plane`];
//! the other two are fixed. The *activation pattern* is the set of hidden units whose pre-activation is
//! positive. As long as it stays the same, each pre-activation and the force are affine functions,
//!
//! ```text
//! zᵢ = αᵢ + βᵢ p + γᵢ r        f = a + b p + c r
//! ```
//!
//! since `σ(z) = z` for active units and `σ(z) = s z` for the others.
//!
//! | file | holds |
//! |---|---|
//! | `relu_network` | the weights, padded to whole SIMD vectors |
//! | `plane` | the two inputs that vary |
//! | `pattern` | activation patterns as bit sets, their hash, the slopes of the units |
//! | `preactivations` | `α, β, γ` of all units in one pattern, computed layer by layer |
//! | `rank_one` | the same for a neighbouring pattern, by an update of rank one |

pub(crate) mod pattern;
mod plane;
pub(crate) mod preactivations;
pub(crate) mod rank_one;
mod relu_network;

pub use plane::Plane;
pub(crate) use relu_network::Layer;
pub use relu_network::ReluNetwork;
