//! Errors of sweeps.

use pam_data::DataError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A sweep that cannot be read, begun or reported. A cell that fails is none of these: its failure is its
/// result.
#[derive(Debug, Error)]
pub enum AblateError {
    /// A file cannot be read or written, or a line of it is wrong.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A sweep has no such name.
    #[error("`{name}` is neither a file nor a sweep that comes with the program: {known}")]
    Unknown {
        /// The name.
        name: String,
        /// The names there are.
        known: String,
    },
    /// A setting from outside the file is wrong.
    #[error("{what}: {message}")]
    Setting {
        /// The option or key.
        what: String,
        /// The problem and its remedy.
        message: String,
    },
    /// A folder holds something else.
    #[error("{}: {message}", path.display())]
    Folder {
        /// The folder or a file of it.
        path: PathBuf,
        /// The problem and its remedy.
        message: String,
    },
}

impl AblateError {
    pub(crate) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Data(DataError::io(path, source))
    }

    pub(crate) fn folder(path: &Path, message: impl Into<String>) -> Self {
        Self::Folder { path: path.to_owned(), message: message.into() }
    }

    pub(crate) fn setting(what: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Setting { what: what.into(), message: message.into() }
    }
}
