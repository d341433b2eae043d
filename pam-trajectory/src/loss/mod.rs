//! Losses: how far a predicted trajectory is from the measured one.
//!
//! One loss a file: [`SquaredError`], [`Normalised`], [`Huber`] and, around any of them, [`Masked`].
//! A closure over `(measured, predicted, cotangents)` that returns the value is a loss as well ([`loss_fn`]), and
//! [`pointwise`] makes one of a function of the errors of one sample. To add one that configuration files name, write its
//! file, name the file below, and add a line to the list of [`AnyLoss`]; one of another crate gets a name with
//! [`NamedLoss`] and [`register`].

mod any;
mod huber;
mod masked;
mod normalised;
mod own;
mod pointwise;
mod shared;
mod spec;
mod squared;

pub use any::*;
pub use huber::HuberForm;
pub use own::{NamedLoss, OwnLoss, register, registered};
pub use pointwise::{Pointwise, SampleErrors, pointwise};
pub use shared::{SharedLoss, loss_fn};

use crate::settings::SettingsError;
use pam_data::Recording;

/// A loss of one trajectory in all four channels `[x, ẋ, P_f, P_e]` (mm, mm/s, kPa, kPa).
///
/// The loss of a data set is the mean over its recordings.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no loss of a trajectory",
    note = "implement `TrajectoryLoss`, or hand a closure to `pam_trajectory::loss::loss_fn`: \
            `loss_fn(|measured, predicted, cotangents| …)`"
)]
pub trait TrajectoryLoss: Sync {
    /// Returns the loss of `predicted`, one row for each sample of `measured`, and writes its
    /// derivative with respect to `predicted` to `cotangents`.
    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64;

    /// Checks the numbers of the loss, and of those that it wraps.
    ///
    /// # Errors
    /// [`SettingsError`] naming the first that is out of range.
    fn check(&self) -> Result<(), SettingsError> {
        Ok(())
    }
}

impl<F> TrajectoryLoss for F
where
    F: Fn(&Recording, &[[f64; 4]], &mut [[f64; 4]]) -> f64 + Sync,
{
    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        self(measured, predicted, cotangents)
    }
}

/// `Σ_c weight_c · mean_k φ_c(predicted_kc − measured_kc)` for a function of channel and error that
/// returns `φ` and `φ'`; the form of all losses that treat samples alike.
fn weighted_mean(
    weights: [f64; 4],
    measured: &Recording,
    predicted: &[[f64; 4]],
    cotangents: &mut [[f64; 4]],
    function: impl Fn(usize, f64) -> (f64, f64),
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
            let (value, slope) = function(i, p[i] - m[i]);
            sums[i] += value;
            c[i] = scale * weights[i] * slope;
        }
    }
    scale * sums.iter().zip(weights).map(|(s, w)| s * w).sum::<f64>()
}
