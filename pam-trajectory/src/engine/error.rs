//! Errors of engines.

use pam_core::ModelError;
use pam_solvers::input::InputError;
use thiserror::Error;

/// A model or windows that an engine cannot simulate.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum EngineError {
    /// A recording cannot drive a solve: it has no samples, or its times do not increase.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The model's force is not one that the engine simulates.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Method, windows and starts of a request do not fit together.
    #[error("{0}")]
    Request(String),
    /// An effect of the model cannot be simulated in these windows.
    #[error("effect `{id}`: {message}")]
    Effect {
        /// Id of the effect.
        id: String,
        /// The fault and its remedy.
        message: String,
    },
}
