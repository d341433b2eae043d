//! What can go wrong.

use pam_effects::simulation::Diverged;
use thiserror::Error;

/// A diagnosis that cannot be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DiagnoseError {
    /// There is too little data.
    #[error("{0}")]
    TooLittle(String),
    /// A setting has an unknown key or an impossible value.
    #[error("settings: {0}")]
    Settings(String),
    /// A field cannot be solved, or its data do not fit it.
    #[error(transparent)]
    Field(#[from] pam_train::field::FieldError),
    /// The simulation of the model itself diverges.
    #[error(
        "{0}; the model is not of this joint, or the data are not in the units of their format"
    )]
    Diverges(#[from] Diverged),
}
