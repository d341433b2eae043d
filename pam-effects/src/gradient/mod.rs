//! Network weights and parameters of effects, trained together through the simulation.
//!
//! [`EffectExtension`] makes effects an [`Extension`](pam_train::Extension) of a trained model: the trainer
//! moves their parameters with the weights, m and ν.
//!
//! **The gradient** is the exact adjoint of the steps that [`simulate`](crate::simulation::simulate) takes, with
//! the network itself in place of its table. A recording is marched in plain numbers; the states at the grid
//! points and the places where the network was asked are kept. Backwards, each step is recorded once more on a
//! tape from its kept state, over the same hooks of the effects, and swept at once: what is needed of a step
//! is some hundred operations. The network is not recorded. Its slopes at the points of a block of
//! steps are found beforehand in matrix products; it stands on the tape as a number with four given
//! derivatives. The adjoints of these numbers then weigh the points' weight derivatives, in matrix products
//! again. What the sensors make of the channels is recorded on a tape over whole series; the low-pass is
//! transposed.
//!
//! **Repeatable.** Recordings go to the threads in groups that do not depend on the number of threads, and sums
//! are taken in the order of the groups.

mod engine;
mod network;
mod observation;
mod window;

pub use engine::EffectGradient;

use crate::effects::AnyEffect;
use crate::error::EffectError;
use crate::model::ExtendedModel;
use pam_core::AnyForce;
use pam_data::Recording;
use pam_data::Subject;
use pam_trajectory::gradient::{ExtendedGradient, ExtendedRequest};
use pam_trajectory::windows::Windows;
use pam_trajectory::{JointGradient, TrajectoryLoss};

impl ExtendedModel {
    /// Value and gradient of the mean loss over recordings, each predicted from its first sample, on all
    /// threads of the current pool: by the network's weights, m, C and ν before softplus, the masses and starts
    /// of each recording, and the parameters of the effects in turn
    /// ([`JointGradient::extension`]).
    ///
    /// # Errors
    /// [`EffectError::Force`] if the model's force is no network.
    pub fn value_and_gradient(
        &self,
        subjects: &[Subject],
        loss: &dyn TrajectoryLoss,
    ) -> Result<JointGradient, EffectError> {
        let AnyForce::Network(network) = &self.joint.force else {
            return Err(EffectError::Force(
                "the force of the model is no network; gradients of extended models are those of networks"
                    .into(),
            ));
        };
        let model = self.joint.clone().map(|v| v, |_| network.clone());
        let windows = Windows::of(subjects, None);
        let effects: Vec<&'static dyn AnyEffect> = self.effects.iter().map(|a| a.effect).collect();
        let values: Vec<f64> = self.effects.iter().flat_map(|a| a.values.clone()).collect();
        let part: Vec<usize> = (0..subjects.len()).collect();
        let starts: Vec<[f64; 4]> = subjects.iter().map(|s| s.recording.initial_state()).collect();
        let indexed = |_: usize, measured: &Recording, states: &[[f64; 4]], by: &mut [[f64; 4]]| {
            loss.value_and_cotangents(measured, states, by)
        };
        let mut engine = EffectGradient::<f64>::new(effects, &values, &windows);
        let free: Vec<f64> = self
            .effects
            .iter()
            .flat_map(|a| a.values[..a.effect.info().parameters.len()].to_vec())
            .collect();
        let request = ExtendedRequest {
            model: &model,
            values: &free,
            windows: &windows,
            part: &part,
            starts: &starts,
        };
        Ok(engine.value_and_gradient(&request, &indexed, true))
    }
}
