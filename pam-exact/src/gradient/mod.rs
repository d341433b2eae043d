//! Derivatives of trajectories: costates backward in time, weights region by region, tangents forward.
//!
//! The field is continuous across a facet, so the saltation matrix of a crossing is the identity (see
//! N. J. Kong et al., *Saltation matrices*, 2024): to first order the state after the crossing does not
//! depend on its time, costates and tangents are continuous, and a crossing contributes nothing.
//!
//! With the costate `λ` of the loss, `ẍ = (u − f_θ(x, ẋ) − B ẋ)/m` gives
//!
//! ```text
//! dL/dθ = −1/m ∫ λ_v ∂f/∂θ dt
//! ```
//!
//! Within a region `∂f/∂θ` is affine in `x` and `ẋ`, so the weights need only the *moments* `∫ λ_v dt`,
//! `∫ λ_v x dt` and `∫ λ_v ẋ dt` over all the time spent in the region, in closed form.
//!
//! | file | holds |
//! |---|---|
//! | `costate` | the backward pass in time: costates and moments |
//! | `weights` | from the moments of all regions to the gradient of the network |
//! | `result` | [`ExactGradient`] |
//! | `sensitivities` | [`forward_sensitivities`], tangents along directions |

pub(crate) mod costate;
mod result;
mod sensitivities;
pub(crate) mod weights;

pub use result::ExactGradient;
pub use sensitivities::{ExactDirection, forward_sensitivities};
