//! Errors of commands.

use pam_ablate::AblateError;
use pam_control::ControlError;
use pam_data::DataError;
use pam_rig::RigError;
use pam_train::curriculum::CurriculumError;
use std::fmt::Display;
use thiserror::Error;

/// An error of a command, with a message of one line.
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
    Rig(#[from] RigError),
    /// Something cannot be planned, carried out or identified.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// A curriculum cannot be read.
    #[error(transparent)]
    Curriculum(#[from] CurriculumError),
    /// Training cannot begin or go on.
    #[error(transparent)]
    Training(#[from] pam_train::training::TrainingError),
    /// An effect of a model is not known, or its values are wrong.
    #[error(transparent)]
    Effect(#[from] pam_effects::EffectError),
    /// A diagnosis cannot be made.
    #[error(transparent)]
    Diagnose(#[from] pam_diagnose::DiagnoseError),
    /// An experiment cannot be planned or judged.
    #[error(transparent)]
    Experiment(#[from] pam_experiment::ExperimentError),
    /// A baseline cannot be fitted, or a comparison not made.
    #[error(transparent)]
    Baseline(#[from] pam_baselines::BaselineError),
    /// A sweep cannot be read, begun or reported.
    #[error(transparent)]
    Ablate(#[from] AblateError),
    /// Options contradict each other, or a value of one is out of range or names something that does not exist.
    #[error("{0}")]
    Usage(String),
    /// The work cannot be done with these data.
    #[error("{0}")]
    Failed(String),
}

/// Wrong usage, in the words of another error.
pub fn usage(error: impl Display) -> CliError {
    CliError::Usage(error.to_string())
}

/// A failure of the work, in the words of another error.
pub fn failed(error: impl Display) -> CliError {
    CliError::Failed(error.to_string())
}

impl CliError {
    /// The command is behind a cargo feature that is off.
    #[cfg(not(all(feature = "completions", feature = "man")))]
    pub(crate) fn without_feature(feature: &str) -> Self {
        usage(format!(
            "this program was built without `{feature}`: build it with \
             `cargo install --path pam-cli --features {feature}`"
        ))
    }

    /// True if the command line is wrong; false for errors in files, data and the work.
    #[must_use]
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::Usage(_)
                | Self::Control(ControlError::Spec { .. })
                | Self::Curriculum(
                    CurriculumError::Override { .. } | CurriculumError::Unknown { .. }
                )
                | Self::Rig(RigError::Protocol { .. } | RigError::Preset { .. })
                | Self::Experiment(pam_experiment::ExperimentError::Setting { .. })
                | Self::Ablate(AblateError::Setting { .. } | AblateError::Unknown { .. })
        )
    }
}
