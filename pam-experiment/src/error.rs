//! Errors of planned experiments.

use pam_data::DataError;
use pam_diagnose::DiagnoseError;
use pam_rig::RigError;
use std::path::PathBuf;
use thiserror::Error;

/// An experiment that cannot be planned or judged.
#[derive(Debug, Error)]
pub enum ExperimentError {
    /// A file cannot be read or written, or a line of it is wrong.
    #[error(transparent)]
    Data(#[from] DataError),
    /// Recordings cannot be diagnosed.
    #[error(transparent)]
    Diagnose(#[from] DiagnoseError),
    /// A protocol or the parameters of a rig are wrong.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The model cannot be simulated under a planned excitation.
    #[error("run `{run}`: {why}")]
    Simulation {
        /// Name of the run.
        run: String,
        /// The problem.
        why: String,
    },
    /// A value from outside is wrong.
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

impl ExperimentError {
    pub(crate) fn setting(what: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Setting { what: what.into(), message: message.into() }
    }
}
