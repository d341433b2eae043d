//! Losses that large errors do not rule.

use super::{TrajectoryLoss, weighted_mean};
use crate::settings::{SettingsError, require, require_weights};
use pam_data::Recording;
use serde::{Deserialize, Serialize};

/// How the quadratic middle meets the linear tails.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HuberForm {
    /// `φ(e) = e²` for `|e| ≤ δ`, else `2δ|e| − δ²`: twice the function of Huber (1964).
    Huber,
    /// `φ(e) = 2δ² (√(1 + (e/δ)²) − 1)`, smooth everywhere: twice the function of Charbonnier et al.
    /// (1997).
    #[default]
    PseudoHuber,
}

/// `Σ_c weight_c · mean_k φ_c(predicted_kc − measured_kc)` with a `φ` that is the square of small
/// errors and grows with slope `2δ_c` beyond the threshold `δ_c`.
///
/// `φ` is twice the function of the literature, so that for errors far below the thresholds this is the
/// [`SquaredError`](super::SquaredError) with the same weights.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Huber {
    /// How middle and tails meet.
    #[serde(default)]
    pub form: HuberForm,
    /// Thresholds `[x, ẋ, P_f, P_e]` (mm, mm/s, kPa, kPa); positive.
    pub thresholds: [f64; 4],
    /// Weight of each channel, in the inverse square of its unit.
    pub weights: [f64; 4],
}

impl HuberForm {
    /// `φ` and `φ'` of an error for a threshold.
    fn value_and_slope(self, error: f64, threshold: f64) -> (f64, f64) {
        match self {
            Self::Huber if error.abs() <= threshold => (error * error, 2.0 * error),
            Self::Huber => {
                (threshold * (2.0 * error.abs() - threshold), 2.0 * threshold * error.signum())
            }
            Self::PseudoHuber => {
                let ratio = error / threshold;
                let root = (1.0 + ratio * ratio).sqrt();
                // √(1 + r²) − 1 = r²/(√(1 + r²) + 1), which keeps the digits of a small error.
                (2.0 * error * error / (root + 1.0), 2.0 * error / root)
            }
        }
    }
}

impl TrajectoryLoss for Huber {
    fn check(&self) -> Result<(), SettingsError> {
        require(self.thresholds.iter().all(|d| d.is_finite() && *d > 0.0), || {
            format!("thresholds must be positive and finite, got {:?}", self.thresholds)
        })?;
        require_weights("the Huber loss", &self.weights)
    }

    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        weighted_mean(self.weights, measured, predicted, cotangents, |i, e| {
            self.form.value_and_slope(e, self.thresholds[i])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn tails_are_linear() {
        for form in [HuberForm::Huber, HuberForm::PseudoHuber] {
            let (far, slope) = form.value_and_slope(1e6, 0.5);
            let (farther, _) = form.value_and_slope(2e6, 0.5);
            assert_relative_eq!(slope, 1.0, max_relative = 1e-9);
            assert_relative_eq!(farther - far, 1e6, max_relative = 1e-6);
        }
    }
}
