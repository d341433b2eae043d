//! Losses: how far a predicted trajectory is from the measured one.

use pam_core::ModelError;
use pam_data::Recording;

/// A loss of one trajectory in all four channels `[x, ẋ, P_f, P_e]` (mm, mm/s, kPa, kPa).
///
/// The loss of a data set is the mean over its recordings.
pub trait TrajectoryLoss: Sync {
    /// Returns the loss of `predicted`, one row for each sample of `measured`, and writes its
    /// derivative with respect to `predicted` to `cotangents`.
    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64;
}

/// `Σ_c weight_c · mean_k (predicted_kc − measured_kc)²` over the channels `[x, ẋ, P_f, P_e]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SquaredError {
    /// Weight of each channel, in the inverse square of its unit.
    pub weights: [f64; 4],
}

impl SquaredError {
    /// Names of the losses that commands know.
    pub const NAMES: &'static [&'static str] = &["paper", "published"];

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

    /// The loss of this name.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`] with the names that exist.
    pub fn from_name(name: &str) -> Result<Self, ModelError> {
        match name {
            "paper" => Ok(Self::paper()),
            "published" => Ok(Self::published()),
            _ => Err(ModelError::UnknownName {
                kind: "loss",
                name: name.to_owned(),
                known: Self::NAMES.join(", "),
            }),
        }
    }
}

impl TrajectoryLoss for SquaredError {
    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        let scale = 1.0 / predicted.len().max(1) as f64;
        let mut sums = [0.0; 4];
        for (k, (p, c)) in predicted.iter().zip(cotangents).enumerate() {
            let m = [
                measured.displacement_mm[k],
                measured.velocity_mm_s[k],
                measured.pressure_flexor_kpa[k],
                measured.pressure_extensor_kpa[k],
            ];
            for i in 0..4 {
                let error = p[i] - m[i];
                sums[i] += error * error;
                c[i] = 2.0 * scale * self.weights[i] * error;
            }
        }
        scale * sums.iter().zip(self.weights).map(|(s, w)| s * w).sum::<f64>()
    }
}
