//! What can go wrong.

use crate::simulation::Diverged;
use thiserror::Error;

/// A diagnosis that cannot be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DiagnoseError {
    /// An effect is not known, or its values are wrong.
    #[error("effect `{id}`: {message}")]
    Effect {
        /// Its id.
        id: String,
        /// What is wrong and what to do.
        message: String,
    },
    /// The model's force is not of the kind that is needed.
    #[error("{0}")]
    Force(String),
    /// There is too little data.
    #[error("{0}")]
    TooLittle(String),
    /// A field of any other system cannot be solved, or its data do not fit it.
    #[error(transparent)]
    Field(#[from] pam_train::field::FieldError),
    /// The model's own simulation diverges.
    #[error(
        "{0}; the model is not of this joint, or the data are not in the units of their format"
    )]
    Diverges(#[from] Diverged),
}
