//! The squared error in units of the measured variance.

use super::{TrajectoryLoss, weighted_mean};
use crate::metrics::variance;
use crate::settings::{SettingsError, require_weights};
use pam_data::{Channel, Recording};
use serde::{Deserialize, Serialize};

/// `Σ_c weight_c · Σ_k (predicted_kc − measured_kc)² / Σ_k (measured_kc − mean_c)²`, which is
/// `Σ_c weight_c (1 − R²_c)` with the [`r2`](crate::metrics::r2) of each channel of the recording.
///
/// No unit is left, so that equal weights ask for equal shares of explained variance, in channels as
/// well as in recordings. A channel that does not vary in a recording has no R² and adds nothing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Normalised {
    /// Weight of each channel `[x, ẋ, P_f, P_e]`, without unit; one each by default.
    pub weights: [f64; 4],
}

impl Default for Normalised {
    fn default() -> Self {
        Self { weights: [1.0; 4] }
    }
}

impl TrajectoryLoss for Normalised {
    fn check(&self) -> Result<(), SettingsError> {
        require_weights("the normalised error", &self.weights)
    }

    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        let weights = std::array::from_fn(|i| {
            let values = measured.channel(Channel::ALL[i]);
            let variance = variance(values);
            // The mean of equal numbers may be off by rounding: their variance is not quite zero then.
            let varies = values.iter().any(|v| *v != values[0]);
            if varies && variance > 0.0 { self.weights[i] / variance } else { 0.0 }
        });
        weighted_mean(weights, measured, predicted, cotangents, |_, e| (e * e, 2.0 * e))
    }
}
