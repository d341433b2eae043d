//! Predictions, losses and gradients of a model on windows of recordings.
//!
//! A [`TrajectoryEngine`] predicts windows, evaluates a loss on them and differentiates it. Engines:
//!
//! - [`ClosedFormEngine`]: the closed form of (leaky) ReLU networks with sealed chambers;
//! - [`SurrogateEngine`]: smooth networks with sealed chambers, on piecewise polynomials of the force;
//! - [`BatchedEngine`]: any network with sealed chambers, trajectories in batches, the discrete adjoint;
//! - [`GeneralEngine`]: any force model, any [`GradientChoice`], one recording at a time.
//!
//! The engine of models with effects, and the list from which an engine is chosen, are in `pam-effects`. All
//! engines fill [`GradientSums`]; [`TrajectoryGradient::mean_of`] turns them into the gradient of the mean loss.

mod batched;
mod closed_form;
mod error;
mod general;
mod gradient;
pub mod pressures;
mod request;
mod sealed_states;
mod surrogate;

pub use batched::BatchedEngine;
pub use closed_form::ClosedFormEngine;
pub use error::EngineError;
pub use general::GeneralEngine;
pub use gradient::{GradientStatistics, GradientSums, TrajectoryGradient};
pub use pam_solvers::sensitivity::GradientChoice;
pub use request::{EngineForce, IndexedLoss, Precision, Progress, TrajectoryRequest};
pub use surrogate::SurrogateEngine;

use crate::loss::TrajectoryLoss;
use pam_core::{JointModel, NetworkForce};
use pam_data::Recording;
use pam_solvers::TrajectoryFailure;
use std::fmt::Debug;

/// A joint with a network force.
pub type NetworkJoint = JointModel<f64, NetworkForce<f64>>;

/// Predicts windows of recordings and differentiates losses, again and again for changing models of one shape.
/// Memory is kept from call to call, and results are the same bits at any number of threads.
pub trait TrajectoryEngine<F = NetworkForce<f64>>: Debug + Send {
    /// The mean of a loss over the windows of a request, each predicted from its start; with `backward` its
    /// gradient, which is meaningless without. Windows whose prediction stops early are left out of the mean
    /// and are listed in [`TrajectoryGradient::failures`].
    ///
    /// # Errors
    /// [`EngineError`] if the engine cannot simulate the model, or a recording cannot drive a solve.
    fn evaluate(
        &mut self,
        request: &TrajectoryRequest<'_, F>,
        loss: &IndexedLoss<'_>,
        backward: bool,
    ) -> Result<TrajectoryGradient, EngineError>;

    /// The states `[x, ẋ, P_f, P_e]` (mm, mm/s, kPa, kPa) of the `index`-th window of the last call at its
    /// sample times; meaningless if its prediction stopped early.
    fn predicted(&mut self, index: usize) -> &[[f64; 4]];

    /// The precision in which the network is evaluated.
    fn precision(&self) -> Precision {
        Precision::F64
    }

    /// Predicts the windows of a request for [`predicted`](Self::predicted). Returns those that stopped early.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    fn predict(
        &mut self,
        request: &TrajectoryRequest<'_, F>,
    ) -> Result<Vec<TrajectoryFailure>, EngineError> {
        Ok(self.evaluate(request, &|_, _, _, _| 0.0, false)?.failures)
    }

    /// The mean loss.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    fn value(
        &mut self,
        request: &TrajectoryRequest<'_, F>,
        loss: &dyn TrajectoryLoss,
    ) -> Result<f64, EngineError> {
        Ok(self.evaluate(request, &of_any_index(loss), false)?.value)
    }

    /// The mean loss and its gradient.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    fn value_and_gradient(
        &mut self,
        request: &TrajectoryRequest<'_, F>,
        loss: &dyn TrajectoryLoss,
    ) -> Result<TrajectoryGradient, EngineError> {
        self.evaluate(request, &of_any_index(loss), true)
    }
}

/// A loss that is the same for all windows.
fn of_any_index(
    loss: &dyn TrajectoryLoss,
) -> impl Fn(usize, &Recording, &[[f64; 4]], &mut [[f64; 4]]) -> f64 + Sync {
    move |_, measured, predicted, cotangents| {
        loss.value_and_cotangents(measured, predicted, cotangents)
    }
}
