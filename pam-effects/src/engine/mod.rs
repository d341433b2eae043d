//! Engines for models with effects, and the choice among all engines.
//!
//! [`choose`] takes the first engine of a list that suits model and settings; [`EffectsEngine`] is the one for
//! models with effects: network weights, m, ν and parameters of effects through one simulation.
//!
//! **The gradient** of [`EffectsEngine`] is the exact adjoint of the steps that
//! [`simulate`](crate::simulation::simulate) takes, with the network itself in place of its table. A recording is
//! simulated in plain numbers; the states at the grid points and the points at which the network was evaluated are
//! kept. Backwards, each step is recorded once more on a tape from its kept state, over the same hooks of the
//! effects, and swept at once: a step needs some hundred operations. The network is not recorded. Its
//! slopes at the points of a block of steps are found beforehand in matrix products; it stands on the tape as a
//! number with four given derivatives. The adjoints of these numbers then weigh the points' weight derivatives, in
//! matrix products again. The sensors' part is recorded on a tape over whole series; the low-pass is transposed.
//!
//! **Repeatable.** Recordings go to the threads in groups that do not depend on the number of threads, and sums
//! are taken in the order of the groups.

mod choice;
mod effects;
mod network;
mod observation;
mod of_network;
mod operating_model;
mod window;

pub use choice::{AUTO, ChooseEngine, EXACT, EngineChoice, SURROGATE, choose};
pub use effects::EffectsEngine;

use crate::model::ExtendedModel;
use pam_data::Subject;
use pam_trajectory::engine::{
    EngineError, TrajectoryEngine, TrajectoryGradient, TrajectoryRequest,
};
use pam_trajectory::{TrajectoryLoss, Windows};

impl ExtendedModel {
    /// Value and gradient of the mean loss over recordings, each predicted from its first sample, on all
    /// threads of the current pool: by the network's weights, m, C and ν before softplus, the masses and starts
    /// of each recording, and the parameters of the effects in turn
    /// ([`TrajectoryGradient::effects`]).
    ///
    /// # Errors
    /// [`EngineError`] if the model's force is no network.
    pub fn value_and_gradient(
        &self,
        subjects: &[Subject],
        loss: &dyn TrajectoryLoss,
    ) -> Result<TrajectoryGradient, EngineError> {
        let windows = Windows::of(subjects, None);
        let parameters = self.parameters();
        let request = TrajectoryRequest {
            effects: &parameters,
            ..TrajectoryRequest::new(&self.joint, &windows)
        };
        EffectsEngine::<f64>::new(&self.effects).value_and_gradient(&request, loss)
    }
}
