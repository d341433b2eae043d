//! Errors of training.

use pam_core::ModelError;
use pam_data::DataError;
use pam_effects::EffectError;
use pam_trajectory::EngineError;
use thiserror::Error;

/// Training that cannot begin or go on.
#[derive(Debug, Error)]
pub enum TrainingError {
    /// The curriculum asks for something that is not there.
    #[error("{0}")]
    Curriculum(String),
    /// A recording or a model file is wrong.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The model cannot be built as asked.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Effects cannot be trained as asked.
    #[error(transparent)]
    Effect(#[from] EffectError),
    /// The model cannot be simulated on the recordings as asked.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The solves diverge where a stage starts.
    #[error("stage `{stage}`, epoch {epoch}: {message}")]
    Diverged {
        /// The stage.
        stage: String,
        /// Its epoch.
        epoch: usize,
        /// Which recording, when, and what to do.
        message: String,
    },
}
