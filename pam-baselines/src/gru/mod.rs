//! A recurrent network: layers of gated recurrent units and a head, `ŷ = W₂ tanh(W₁ h + b₁) + b₂`.
//!
//! The network reads the measured state and the force of a sample, scaled to [−1, 1], and gives the scaled
//! state of the next one. After a warm-up on measured samples it reads its own predictions. Training
//! predicts windows in the same way and differentiates through all of it: warm-up, recursion, and outputs
//! that are inputs again (Wang and Realmuto 2026, supplement A).

mod checkpoint;
mod gradient;
mod model;
mod network;
mod parameters;
mod scaling;
mod train;

pub use checkpoint::read_checkpoint;
pub use gradient::{LOSS_WEIGHTS, Tape, Window};
pub use model::GruModel;
pub use network::{Network, Running};
pub use parameters::{INPUTS, OUTPUTS, Part, Shape};
pub use scaling::Scaling;
pub use train::{BatchGradient, History, LANES, Samples};

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
    /// Measured samples before a prediction.
    pub warm_up: usize,
    /// Samples that are predicted recursively in training.
    pub horizon: usize,
    /// Windows in a step of Adam.
    pub batch: usize,
    /// Windows drawn for an epoch.
    pub windows_per_epoch: usize,
    /// Epochs at most.
    pub epochs: usize,
    /// Epochs without a better loss on the validation windows after which training ends.
    pub patience: usize,
    /// Windows of the training recordings that decide which epoch is kept.
    pub validation_windows: usize,
    /// Rate at the start; it falls as a cosine.
    pub rate: f64,
    /// Largest norm of the gradient.
    pub clip: f64,
}

impl Default for Gru {
    fn default() -> Self {
        Self {
            hidden: 96,
            layers: 2,
            warm_up: 100,
            horizon: 100,
            batch: 64,
            windows_per_epoch: 2048,
            epochs: 60,
            patience: 15,
            validation_windows: 512,
            rate: 2e-3,
            clip: 1.0,
        }
    }
}

impl Method for Gru {
    fn title(&self) -> String {
        "GRU".into()
    }

    fn check(&self) -> Result<(), String> {
        if self.hidden == 0 || !self.hidden.is_multiple_of(16) {
            return Err(format!("hidden = {} must be a multiple of 16", self.hidden));
        }
        for (name, value) in [
            ("layers", self.layers),
            ("warm_up", self.warm_up),
            ("horizon", self.horizon),
            ("batch", self.batch),
            ("windows_per_epoch", self.windows_per_epoch),
            ("epochs", self.epochs),
            ("validation_windows", self.validation_windows),
        ] {
            if value == 0 {
                return Err(format!("{name} must be positive"));
            }
        }
        for (name, value) in [("rate", self.rate), ("clip", self.clip)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(format!("{name} = {value} must be positive and finite"));
            }
        }
        Ok(())
    }

    fn fit(
        &self,
        training: &TrainingSet<'_>,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Box<dyn FittedModel>, BaselineError> {
        let recordings: Vec<_> = training.subjects.iter().map(|s| &s.recording).collect();
        let step_s = common_step_s(&recordings).map_err(|why| BaselineError::unfit("GRU", why))?;
        let scaling = Scaling::of(training.subjects);
        let samples = Samples::of(training.subjects, &scaling);
        let shape = Shape { hidden: self.hidden, layers: self.layers };
        let (numbers, history) = train::train(self, shape, &samples, training.seed, progress)?;
        Ok(Box::new(GruModel {
            network: Network::new(shape, &numbers),
            numbers,
            scaling,
            warm_up: self.warm_up,
            step_s: Some(step_s),
            history: Some(history),
        }))
    }
}
