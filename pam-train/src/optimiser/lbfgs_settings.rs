//! Settings of L-BFGS.

use pam_core::settings::{SettingsError, require};
use serde::{Deserialize, Serialize};

/// Settings of L-BFGS.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LbfgsSettings {
    /// Steps whose curvature is remembered.
    pub memory: usize,
    /// c₁: share of the first slope by which a step must lower the value.
    pub armijo: f64,
    /// c₂: share of the first slope that may be left at the end of a step.
    pub curvature: f64,
    /// Evaluations that one line search may use.
    pub evaluations: usize,
    /// Euclidean length of the step that is tried first while no curvature is known.
    pub first_step: f64,
    /// Euclidean length that no step exceeds, if any.
    pub largest_step: Option<f64>,
}

impl Default for LbfgsSettings {
    /// Ten steps; c₁ = 10⁻⁴ and c₂ = 0.9 as Nocedal and Wright (2006, section 3.1) advise for
    /// quasi-Newton methods.
    fn default() -> Self {
        Self {
            memory: 10,
            armijo: 1e-4,
            curvature: 0.9,
            evaluations: 20,
            first_step: 0.1,
            largest_step: None,
        }
    }
}

impl LbfgsSettings {
    /// Checks that each setting is in the range for which the method is defined.
    ///
    /// # Errors
    /// [`SettingsError`] naming the first that is not.
    pub fn check(&self) -> Result<(), SettingsError> {
        let Self { memory, armijo, curvature, evaluations, first_step, largest_step } = *self;
        require(memory > 0 && evaluations > 0, || {
            format!("memory and evaluations must be positive, got {memory} and {evaluations}")
        })?;
        require(0.0 < armijo && armijo < curvature && curvature < 1.0, || {
            format!("0 < armijo < curvature < 1 must hold, got {armijo} and {curvature}")
        })?;
        for length in [first_step, largest_step.unwrap_or(1.0)] {
            require(length.is_finite() && length > 0.0, || {
                format!("lengths of steps must be positive and finite, got {length}")
            })?;
        }
        Ok(())
    }
}
