//! A recurrent network: layers of gated recurrent units and a head, `ŷ = W₂ tanh(W₁ h + b₁) + b₂`.
//!
//! The network reads the measured state and the force of a sample, scaled to [−1, 1], and gives the scaled
//! state of the next one. After a warm-up on measured samples it reads its own predictions. Training
//! predicts windows in the same way and differentiates through all of it: warm-up, recursion, and outputs
//! that are inputs again (Wang and Realmuto 2026, supplement A).
//!
//! A network may step over samples: with `samples_per_step` = 50 at 1 kHz it steps by 50 ms, reads the mean
//! force of each step, and a hundred steps are five seconds. That is how gradients through 100 steps see
//! whole periods of the motion, and what must be remembered for it: the sealed air. With 1 it steps as the
//! published one, and a hundred steps are a twentieth of the slowest period.

mod backward;
mod batch;
mod model;
mod network;
mod parameters;
mod samples;
mod scaling;
mod tape;
mod train;

pub use batch::{BatchGradient, Block, TASK_WINDOWS};
pub use model::GruModel;
pub use network::{Network, Running};
pub use parameters::{INPUTS, OUTPUTS, Part, Shape};
pub use samples::Samples;
pub use scaling::Scaling;
pub use tape::{Begin, LOSS_WEIGHTS, Tape, Window};
pub use train::History;

use crate::batched::{check_counts, check_positive, check_width};
use crate::error::BaselineError;
use crate::koopman::common_step_s;
use crate::method::{FittedModel, Method, TrainingSet};
use serde::{Deserialize, Serialize};

/// How the network is made and trained.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gru {
    /// Width of layers and head; a multiple of 16.
    pub hidden: usize,
    /// Number of recurrent layers.
    pub layers: usize,
    /// Samples of a step.
    pub samples_per_step: usize,
    /// Measured steps before a prediction.
    pub warm_up: usize,
    /// Steps that are predicted recursively under one gradient.
    pub horizon: usize,
    /// Most segments of `horizon` steps of a rollout in training; with 1 every segment begins with a
    /// warm-up.
    pub rollout: usize,
    /// Share of the rollouts that begin where a recording begins, at rest.
    pub rest_share: f64,
    /// Rollouts side by side, the windows of a step of Adam.
    pub batch: usize,
    /// Steps of Adam in an epoch.
    pub updates_per_epoch: usize,
    /// Epochs at most.
    pub epochs: usize,
    /// Epochs without a better free run over the training recordings after which training ends.
    pub patience: usize,
    /// Rate at the start; it falls as a cosine.
    pub rate: f64,
    /// Largest norm of the gradient.
    pub clip: f64,
    /// Share of the running mean of the weights that an update leaves; 0 uses the last weights themselves.
    pub averaging: f64,
}

impl Default for Gru {
    fn default() -> Self {
        Self {
            hidden: 96,
            layers: 2,
            samples_per_step: 50,
            warm_up: 100,
            horizon: 100,
            rollout: 13,
            rest_share: 0.5,
            batch: 64,
            updates_per_epoch: 50,
            epochs: 50,
            patience: 25,
            rate: 2e-3,
            clip: 1.0,
            averaging: 0.99,
        }
    }
}

impl Method for Gru {
    fn title(&self) -> String {
        "GRU".into()
    }

    fn check(&self) -> Result<(), String> {
        check_width("hidden", self.hidden)?;
        check_counts(&[
            ("layers", self.layers),
            ("samples_per_step", self.samples_per_step),
            ("warm_up", self.warm_up),
            ("horizon", self.horizon),
            ("rollout", self.rollout),
            ("batch", self.batch),
            ("updates_per_epoch", self.updates_per_epoch),
            ("epochs", self.epochs),
        ])?;
        if !(0.0..=1.0).contains(&self.rest_share) {
            return Err(format!("rest_share = {} must lie between 0 and 1", self.rest_share));
        }
        if !(0.0..1.0).contains(&self.averaging) {
            return Err(format!("averaging = {} must be from 0 to below 1", self.averaging));
        }
        check_positive(&[("rate", self.rate), ("clip", self.clip)])
    }

    fn fit(
        &self,
        training: &TrainingSet<'_>,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Box<dyn FittedModel>, BaselineError> {
        let recordings: Vec<_> = training.subjects.iter().map(|s| &s.recording).collect();
        let step_s = common_step_s(&recordings).map_err(|why| BaselineError::unfit("GRU", why))?;
        let scaling = Scaling::of(training.subjects);
        let samples = Samples::of(training.subjects, &scaling, self.samples_per_step, self.warm_up);
        let shape = Shape { hidden: self.hidden, layers: self.layers };
        let (numbers, history) = train::train(self, shape, &samples, training.seed, progress)?;
        Ok(Box::new(GruModel {
            network: Network::new(shape, &numbers),
            numbers,
            scaling,
            warm_up: self.warm_up,
            samples_per_step: self.samples_per_step,
            step_s: Some(step_s),
            history: Some(history),
        }))
    }
}
