//! Errors of the rig.

use crate::effects::VocabularyError;
use pam_data::DataError;
use std::path::PathBuf;
use thiserror::Error;

/// An error of the rig.
#[derive(Debug, Error)]
pub enum RigError {
    /// A parameter is impossible.
    #[error("`{field}` = {value}: {message}")]
    Parameter {
        /// The path of field names.
        field: String,
        /// The value.
        value: f64,
        /// The problem and its remedy.
        message: String,
    },
    /// A protocol that was not read from a file is wrong.
    #[error("protocol `{name}`: {message}")]
    Protocol {
        /// Its name.
        name: String,
        /// The problem and its remedy.
        message: String,
    },
    /// A parameter set that is neither a file nor one that comes with the rig.
    #[error(
        "rig `{name}`: neither a file nor one of the parameter sets that come with the rig: {known}"
    )]
    Preset {
        /// The name.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// The folder already holds something else.
    #[error("{}: {message}", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The problem and its remedy.
        message: String,
    },
    /// The rig's motion or its readings do not stay finite.
    #[error(
        "run `{name}`: the rig has no finite motion or reading at t = {time_s:.4} s; its parameters are far from those of \
         any rig"
    )]
    Diverged {
        /// Name of the run.
        name: String,
        /// Time since the excitation began, s.
        time_s: f64,
    },
    /// An effect as written is wrong.
    #[error(transparent)]
    Effect(#[from] VocabularyError),
    /// A file cannot be read or written, or a settings or protocol file is wrong.
    #[error(transparent)]
    Data(#[from] DataError),
}
