//! Errors of effects and extended models.

use pam_core::error::OWN_PART;
use pam_vocabulary::VocabularyError;
use thiserror::Error;

/// An effect or an extended model that cannot be used as asked.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum EffectError {
    /// An effect is not known.
    #[error("there is no effect `{id}`; there are {}; {OWN_PART}", known.join(", "))]
    Unknown {
        /// The id as written.
        id: String,
        /// The known ids.
        known: Vec<&'static str>,
    },
    /// A file of effects cannot be read.
    #[error("{file}: {message}")]
    File {
        /// The file.
        file: String,
        /// Line, column and the fault.
        message: String,
    },
    /// The values of an effect are wrong.
    #[error(transparent)]
    Vocabulary(#[from] VocabularyError),
    /// An effect cannot be used with this model or these recordings.
    #[error("effect `{id}`: {message}")]
    Effect {
        /// Its id.
        id: String,
        /// The fault and its remedy.
        message: String,
    },
}
