//! Errors of baselines and comparisons.

use pam_data::DataError;
use thiserror::Error;

/// A baseline that cannot be fitted, or a comparison that cannot be made.
#[derive(Debug, Error)]
pub enum BaselineError {
    /// A configuration, a recording or a model file cannot be read or is wrong.
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
}
