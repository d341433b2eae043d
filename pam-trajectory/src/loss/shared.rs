//! Closures as losses, and a loss that has left its type behind.

use super::TrajectoryLoss;
use crate::settings::SettingsError;
use pam_data::Recording;
use std::fmt;
use std::sync::Arc;

/// A closure `|measured, predicted, cotangents|` as a [`TrajectoryLoss`], without its types written out.
///
/// ```
/// use pam_trajectory::loss::loss_fn;
///
/// // The squared error of the last displacement, mm².
/// let loss = loss_fn(|measured, predicted, cotangents| {
///     let k = predicted.len() - 1;
///     let e = predicted[k][0] - measured.displacement_mm[k];
///     cotangents[k][0] = 2.0 * e;
///     e * e
/// });
/// # let _: &dyn pam_trajectory::TrajectoryLoss = &loss;
/// ```
pub fn loss_fn<F>(loss: F) -> F
where
    F: Fn(&Recording, &[[f64; 4]], &mut [[f64; 4]]) -> f64 + Sync,
{
    loss
}

/// Any loss, closures included, that can be kept and copied.
#[derive(Clone)]
pub struct SharedLoss(Arc<dyn TrajectoryLoss + Send>);

impl SharedLoss {
    /// A loss to keep.
    pub fn new(loss: impl TrajectoryLoss + Send + 'static) -> Self {
        Self(Arc::new(loss))
    }
}

impl fmt::Debug for SharedLoss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SharedLoss").finish_non_exhaustive()
    }
}

impl TrajectoryLoss for SharedLoss {
    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        self.0.value_and_cotangents(measured, predicted, cotangents)
    }

    fn check(&self) -> Result<(), SettingsError> {
        self.0.check()
    }
}
