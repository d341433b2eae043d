//! Errors of effects and extended models.

use thiserror::Error;

/// An effect or an extended model that cannot be used as asked.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum EffectError {
    /// An effect is not known, or its values are wrong.
    #[error("effect `{id}`: {message}")]
    Effect {
        /// Its id.
        id: String,
        /// The fault and its remedy.
        message: String,
    },
    /// The model's force is not of the required kind.
    #[error("{0}")]
    Force(String),
}
