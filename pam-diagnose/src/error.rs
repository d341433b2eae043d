//! Errors of a diagnosis.

#[cfg(feature = "joint")]
use pam_data::plausibility::Finding;
#[cfg(feature = "joint")]
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
    /// The recordings contradict the physics of the joint: wrong units, swapped or flipped columns.
    #[cfg(feature = "joint")]
    #[error("{}", sentence(.0))]
    Implausible(Vec<Finding>),
    /// An effect cannot be made.
    #[cfg(feature = "joint")]
    #[error(transparent)]
    Effect(#[from] pam_effects::EffectError),
    /// A recording is too long to be simulated.
    #[cfg(feature = "joint")]
    #[error(transparent)]
    TooLong(#[from] pam_effects::simulation::TooLong),
    /// The mechanics of the model is too fast for the many simulations of a diagnosis.
    #[cfg(feature = "joint")]
    #[error(
        "{recording}: the model's joint moves so fast that it needs {substeps} substeps in a step of 4 ms, more than the setting \
         data.most_substeps = {most}; the model is not of this joint, or its mass or force is not in the units of the format"
    )]
    TooFast {
        /// The recording on which it does.
        recording: String,
        /// Substeps that it needs; 32 may not be enough.
        substeps: usize,
        /// Most that are allowed.
        most: usize,
    },
    /// The simulation of the model itself diverges.
    #[cfg(feature = "joint")]
    #[error(
        "{recording}: {diverged}; the model is not of this joint, the data are not in the units of their format, or the actuator \
         delivers less than the recorded force"
    )]
    Diverges {
        /// The recording on which it does.
        recording: String,
        /// The time at which it does.
        diverged: Diverged,
    },
}

/// All findings in one line.
#[cfg(feature = "joint")]
fn sentence(findings: &[Finding]) -> String {
    findings.iter().map(Finding::to_string).collect::<Vec<_>>().join("; ")
}
