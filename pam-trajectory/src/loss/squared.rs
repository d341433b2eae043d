//! The squared error.

use super::{TrajectoryLoss, weighted_mean};
use crate::settings::{SettingsError, require_weights};
use pam_data::Recording;
use serde::{Deserialize, Serialize};

/// `Σ_c weight_c · mean_k (predicted_kc − measured_kc)²` over the channels `[x, ẋ, P_f, P_e]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SquaredError {
    /// Weight of each channel, in the inverse square of its unit.
    pub weights: [f64; 4],
}

impl SquaredError {
    /// The loss as the paper writes it:
    /// `100 · mean[(x̂−x)² + (ẋ̂−ẋ)²] + mean[(P̂_f−P_f)² + (P̂_e−P_e)²]` (Wang and Realmuto 2026,
    /// section III).
    #[must_use]
    pub fn paper() -> Self {
        Self { weights: [100.0, 100.0, 1.0, 1.0] }
    }

    /// The loss as the published code computes it: its means run over both columns of a pair at once,
    /// which makes each term half that of the paper.
    #[must_use]
    pub fn published() -> Self {
        Self { weights: [50.0, 50.0, 0.5, 0.5] }
    }
}

impl TrajectoryLoss for SquaredError {
    fn check(&self) -> Result<(), SettingsError> {
        require_weights("the squared error", &self.weights)
    }

    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        weighted_mean(self.weights, measured, predicted, cotangents, |_, e| (e * e, 2.0 * e))
    }
}
