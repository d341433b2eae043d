//! Loss and gradient of a model on recordings.
//!
//! - [`sealed`]: the fast path for a network force and sealed chambers: two states in closed form
//!   (leaky ReLU) or in batched lanes,
//!   pressures by the gas law, the exact discrete adjoint;
//! - [`general`]: any force model, any gradient method;
//! - [`pressures`]: the pressures of sealed chambers along a motion, forward and backward.

#[cfg(test)]
mod exact_tests;
pub mod general;
pub mod pressures;
mod request;
pub mod sealed;

pub use pam_solvers::sensitivity::GradientChoice;
pub use request::{ExtendedGradient, ExtendedRequest};
pub use sealed::SealedGradient;

use pam_core::{JointModel, NetworkForce, RawParameters, SealedMasses};
use pam_solvers::TrajectoryFailure;

/// A joint with a network force.
pub type NetworkJoint = JointModel<f64, NetworkForce<f64>>;

/// Value and gradient of the mean loss over recordings.
#[derive(Debug, Clone, PartialEq)]
pub struct JointGradient {
    /// The mean of the losses of the recordings that were predicted to their end.
    pub value: f64,
    /// The loss of each recording; NaN where the prediction stopped early.
    pub values: Vec<f64>,
    /// With respect to the force's parameters, in their order
    /// (see [`ParametricForce`](pam_core::ParametricForce)).
    pub force: Vec<f64>,
    /// With respect to m, C and ν before softplus.
    pub raw: RawParameters,
    /// With respect to the numbers of an [`Extension`](crate::Extension); empty without one.
    pub extension: Vec<f64>,
    /// With respect to the auxiliary damping B (kg/s).
    pub auxiliary_damping: f64,
    /// With respect to the sealed masses of each recording (g).
    pub masses: Vec<SealedMasses>,
    /// With respect to the initial state `[x, ẋ, P_f, P_e]` of each recording.
    pub initial_states: Vec<[f64; 4]>,
    /// The predicted states `[x, ẋ, P_f, P_e]` of each recording at its sample times; empty where the
    /// prediction stopped early, or where the method keeps them for itself.
    pub states: Vec<Vec<[f64; 4]>>,
    /// Recordings whose prediction stopped early; they add nothing.
    pub failures: Vec<TrajectoryFailure>,
    /// Work that was done.
    pub statistics: GradientStatistics,
}

/// Counts of one gradient, over all recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GradientStatistics {
    /// Accepted steps.
    pub accepted: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Evaluations of the vector field.
    pub evaluations: usize,
    /// Points at which the field was linearised or pulled back.
    pub pullbacks: usize,
    /// Bytes kept of the forward solve for the backward pass.
    pub stored_bytes: usize,
}
