//! What a command can fail with.

use pam_data::DataError;
use thiserror::Error;

/// An error of a command, told in one line.
#[derive(Debug, Error)]
pub enum CliError {
    /// A file cannot be read, understood or written.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A model cannot be built as asked.
    #[error(transparent)]
    Model(#[from] pam_core::ModelError),
    /// The virtual rig cannot do what is asked.
    #[error(transparent)]
    Rig(#[from] pam_rig::RigError),
    /// Something cannot be planned, carried out or identified.
    #[error(transparent)]
    Control(#[from] pam_control::ControlError),
    /// A curriculum cannot be read.
    #[error(transparent)]
    Curriculum(#[from] pam_train::curriculum::CurriculumError),
    /// Training cannot begin or go on.
    #[error(transparent)]
    Training(#[from] pam_train::training::TrainingError),
    /// An effect of a model is not known, or its values are wrong.
    #[error(transparent)]
    Effect(#[from] pam_effects::EffectError),
    /// A diagnosis cannot be made.
    #[error(transparent)]
    Diagnose(#[from] pam_diagnose::DiagnoseError),
    /// A baseline cannot be fitted, or a comparison not made.
    #[error(transparent)]
    Baseline(#[from] pam_baselines::BaselineError),
    /// A sweep cannot be read, begun or told.
    #[error(transparent)]
    Ablate(#[from] pam_ablate::AblateError),
    /// Options contradict each other or name something that does not exist.
    #[error("{0}")]
    Usage(String),
}
