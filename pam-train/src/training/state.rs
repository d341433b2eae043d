//! The state of a training run.

use crate::coordinates::Scaling;
use crate::optimiser::{Adam, Lbfgs};
use crate::schedule::{EarlyStop, Rate};
use serde::{Deserialize, Serialize};

/// The optimiser of the running stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OptimiserState {
    /// Adam or AdamW.
    Adam(Adam),
    /// L-BFGS.
    Lbfgs(Lbfgs),
}

/// The best coordinates of a stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Best {
    /// Their loss.
    pub loss: f64,
    /// The coordinates.
    pub at: Vec<f64>,
    /// The epoch of the stage that began with them.
    pub epoch: usize,
}

/// Trainable starts of windows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Starts {
    /// States `[x, ẋ, P_f, P_e]` at the starts (mm, mm/s, kPa, kPa).
    pub states: Vec<[f64; 4]>,
    /// Their optimiser.
    pub optimiser: Adam,
}

/// The state of a stage that is trained through the solver.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageState {
    /// Epochs done.
    pub epoch: usize,
    /// Coordinates at the start, from which the masses were computed.
    pub start: Vec<f64>,
    /// The optimiser.
    pub optimiser: OptimiserState,
    /// The learning rate.
    pub rate: Rate,
    /// When to stop.
    pub stop: Option<EarlyStop>,
    /// Whether no step lowers the loss any more.
    pub stopped: bool,
    /// Factor of the rate after rollbacks.
    pub reduction: f64,
    /// Last coordinates and optimiser whose solves all ended.
    pub sound: Option<(Vec<f64>, OptimiserState)>,
    /// The best so far.
    pub best: Option<Best>,
    /// Trainable starts, if the stage has them.
    pub starts: Option<Starts>,
    /// Loss of the first epoch.
    pub first_loss: Option<f64>,
    /// Time spent, s.
    pub seconds: f64,
}

/// The result of a finished stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageResult {
    /// Its name.
    pub name: String,
    /// Epochs.
    pub epochs: usize,
    /// Time, s.
    pub seconds: f64,
    /// Loss of the first epoch (of a regression: the residual force in N, or pressure in kPa).
    pub first_loss: Option<f64>,
    /// Best loss.
    pub best_loss: f64,
    /// Mean R² of `[x, ẋ, P_f, P_e]` over its recordings.
    pub r2_train: [Option<f64>; 4],
    /// Mean R² over the held-out recordings.
    pub r2_held_out: [Option<f64>; 4],
}

/// Everything that decides how training goes on. Training from a state that was saved and read back
/// gives the same bits as training that went on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrainingState {
    /// Index of the running stage; the number of stages when all are done.
    pub stage: usize,
    /// Epochs done in all stages.
    pub epochs: usize,
    /// The coordinates.
    pub at: Vec<f64>,
    /// Scale of inputs and output of the network.
    pub scaling: Scaling,
    /// Units of the effects' coordinates; empty until a stage needs them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub units: Vec<f64>,
    /// Within the running stage; absent between stages.
    pub within: Option<StageState>,
    /// Results of finished stages.
    pub results: Vec<StageResult>,
    /// Messages for the reader.
    pub events: Vec<String>,
}

impl TrainingState {
    /// True if all vectors have the length of the coordinates, and the stage is one of so many.
    pub(super) fn fits(&self, len: usize, stages: usize) -> bool {
        let optimiser = |state: &OptimiserState| match state {
            OptimiserState::Adam(adam) => adam.fits(len),
            OptimiserState::Lbfgs(lbfgs) => lbfgs.fits(len),
        };
        let within = |s: &StageState| {
            s.start.len() == len
                && optimiser(&s.optimiser)
                && s.sound.as_ref().is_none_or(|(at, state)| at.len() == len && optimiser(state))
                && s.best.as_ref().is_none_or(|best| best.at.len() == len)
                && s.starts.as_ref().is_none_or(|s| s.optimiser.fits(4 * s.states.len()))
        };
        self.at.len() == len && self.stage <= stages && self.within.as_ref().is_none_or(within)
    }
}

/// One epoch in numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EpochRow {
    /// Index of the stage.
    pub stage: usize,
    /// Epoch of the stage, from one.
    pub epoch: usize,
    /// Epoch of the run, from one.
    pub total_epoch: usize,
    /// The loss, regularisers included.
    pub loss: f64,
    /// The learning rate.
    pub rate: f64,
    /// Norm of the gradient before it was cut.
    pub gradient_norm: f64,
    /// Reflected mass, kg.
    pub mass_kg: f64,
    /// Deformation coefficient.
    pub deformation: f64,
    /// Parameters of the effects in turn; empty without effects.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<f64>,
    /// Mean R² of `[x, ẋ, P_f, P_e]` over the held-out recordings with the coordinates that the epoch
    /// ends with, if it is one that is scored (`score_every`) and there are any.
    pub r2_held_out: Option<[f64; 4]>,
    /// Time of the epoch without scoring, s.
    pub seconds: f64,
}
