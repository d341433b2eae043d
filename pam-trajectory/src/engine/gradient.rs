//! The gradient of a mean loss.

use pam_core::{JointModel, RawParameters, Scalar, SealedMasses};
use pam_solvers::TrajectoryFailure;

/// Value and gradient of the mean loss over windows of recordings.
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryGradient {
    /// The mean of the losses of the windows that were predicted to their end.
    pub value: f64,
    /// The loss of each window; NaN where the prediction stopped early.
    pub values: Vec<f64>,
    /// With respect to the force's parameters, in their order
    /// (see [`ParametricForce`](pam_core::ParametricForce)).
    pub force: Vec<f64>,
    /// With respect to m, C and ν before softplus.
    pub raw: RawParameters,
    /// With respect to the auxiliary damping B (kg/s).
    pub auxiliary_damping: f64,
    /// With respect to the parameters of the model's effects in turn; empty without effects.
    pub effects: Vec<f64>,
    /// With respect to the sealed masses of each window (g).
    pub masses: Vec<SealedMasses>,
    /// With respect to the initial state `[x, ẋ, P_f, P_e]` of each window.
    pub initial_states: Vec<[f64; 4]>,
    /// Windows whose prediction stopped early; they contribute nothing.
    pub failures: Vec<TrajectoryFailure>,
    /// Work that was done.
    pub statistics: GradientStatistics,
}

/// Counts of one gradient, over all windows.
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

/// Sums of losses and their derivatives over the windows that were predicted to their end; what belongs to one
/// window is zero where its prediction stopped early.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GradientSums {
    /// The loss of each window; NaN where the prediction stopped early.
    pub values: Vec<f64>,
    /// By the force's parameters.
    pub force: Vec<f64>,
    /// By m, C and ν, in any form of theirs.
    pub joint: [f64; 3],
    /// Derivatives of that form by m, C and ν before softplus.
    pub joint_by_raw: [f64; 3],
    /// By the auxiliary damping (kg/s).
    pub auxiliary_damping: f64,
    /// By the parameters of the effects.
    pub effects: Vec<f64>,
    /// By the masses of flexor and extensor (g) of each window.
    pub masses: Vec<[f64; 2]>,
    /// By the initial state of each window.
    pub initial_states: Vec<[f64; 4]>,
    /// Windows whose prediction stopped early.
    pub failures: Vec<TrajectoryFailure>,
    /// Work that was done.
    pub statistics: GradientStatistics,
}

impl GradientSums {
    /// Derivatives of the physical m, C and ν by those before softplus: the logistic function.
    pub fn physical_by_raw<F>(model: &JointModel<f64, F>) -> [f64; 3] {
        let raw = &model.raw;
        [raw.mass, raw.gas_coefficient, raw.deformation].map(Scalar::sigmoid)
    }
}

impl TrajectoryGradient {
    /// The gradient of the mean over the windows that were predicted to their end.
    #[must_use]
    pub fn mean_of(sums: GradientSums) -> Self {
        let mean = 1.0 / (sums.values.len() - sums.failures.len()).max(1) as f64;
        let scaled = |sums: Vec<f64>| sums.into_iter().map(|sum| mean * sum).collect();
        let raw = |i: usize| mean * sums.joint[i] * sums.joint_by_raw[i];
        Self {
            value: mean * sums.values.iter().filter(|v| !v.is_nan()).sum::<f64>(),
            force: scaled(sums.force),
            raw: RawParameters { mass: raw(0), gas_coefficient: raw(1), deformation: raw(2) },
            auxiliary_damping: mean * sums.auxiliary_damping,
            effects: scaled(sums.effects),
            masses: sums
                .masses
                .iter()
                .map(|m| SealedMasses { flexor_g: mean * m[0], extensor_g: mean * m[1] })
                .collect(),
            initial_states: sums.initial_states.iter().map(|y| y.map(|v| mean * v)).collect(),
            values: sums.values,
            failures: sums.failures,
            statistics: sums.statistics,
        }
    }
}
