//! Errors of curricula.

use pam_data::DataError;
use thiserror::Error;

/// A curriculum that cannot be used.
#[derive(Debug, Error)]
pub enum CurriculumError {
    /// The file cannot be read, or a line of it is wrong.
    #[error(transparent)]
    Data(#[from] DataError),
    /// An override is wrong.
    #[error("--set {text}: {message}")]
    Override {
        /// The override as written.
        text: String,
        /// The fault and its remedy.
        message: String,
    },
    /// No curriculum has this name.
    #[error("`{name}` is neither a file nor a curriculum that comes with the program: {known}")]
    Unknown {
        /// The name.
        name: String,
        /// The names there are.
        known: String,
    },
    /// A setting is impossible, or settings contradict each other.
    #[error("curriculum `{name}`: {message}")]
    Sense {
        /// Its name.
        name: String,
        /// The fault and its remedy.
        message: String,
    },
}
