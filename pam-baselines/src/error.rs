//! Errors of baselines and comparisons.

use pam_data::DataError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A baseline that cannot be fitted, or a comparison that cannot be made.
#[derive(Debug, Error)]
pub enum BaselineError {
    /// A recording or a model file is wrong.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A model cannot be built as asked.
    #[error(transparent)]
    Model(#[from] pam_core::ModelError),
    /// The hybrid model cannot be trained.
    #[error(transparent)]
    Training(#[from] pam_train::training::TrainingError),
    /// The curriculum of the hybrid model cannot be used.
    #[error(transparent)]
    Curriculum(#[from] pam_train::curriculum::CurriculumError),
    /// The equilibrium-point model cannot be fitted.
    #[error(transparent)]
    Control(#[from] pam_control::ControlError),
    /// The configuration file cannot be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A place in the configuration is wrong.
    #[error("{}:{line}: {message}", path.display())]
    Place {
        /// The file.
        path: PathBuf,
        /// Line, counted from one.
        line: usize,
        /// The problem and its remedy.
        message: String,
    },
    /// A published file holds something else than it should.
    #[error("{}: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The problem.
        message: String,
    },
    /// The data or the settings do not allow what is asked.
    #[error("{model}: {why}")]
    Unfit {
        /// The model.
        model: String,
        /// The problem and its remedy.
        why: String,
    },
    /// A signal asked to stop.
    #[error("interrupted; what was finished is kept, the same command with --resume goes on")]
    Interrupted,
}

impl BaselineError {
    /// Something that a model cannot do.
    pub(crate) fn unfit(model: &str, why: impl Into<String>) -> Self {
        Self::Unfit { model: model.to_owned(), why: why.into() }
    }

    /// A file that is wrong as a whole.
    pub(crate) fn file(path: &Path, message: impl Into<String>) -> Self {
        Self::File { path: path.to_owned(), message: message.into() }
    }
}
