//! A recording with its sealed masses.

use crate::error::DataError;
use crate::masses::{MassChoice, MassOrigin, resolve_masses};
use crate::recording::Recording;
use pam_core::{ForceModel, JointModel, SealedMasses};

/// A recording with the masses to predict it with.
#[derive(Debug, Clone)]
pub struct Subject {
    /// The recording.
    pub recording: Recording,
    /// Sealed masses.
    pub masses: SealedMasses,
    /// Where the masses came from.
    pub origin: MassOrigin,
}

impl Subject {
    /// A recording with the masses that it gives, or those of the model's gas law at its reading at rest.
    ///
    /// # Errors
    /// [`DataError`] if the masses are not positive.
    pub fn of<F: ForceModel<f64>>(
        recording: Recording,
        model: &JointModel<f64, F>,
    ) -> Result<Self, DataError> {
        let (masses, origin) = resolve_masses(&recording, model, true, MassChoice::GasLaw, None)?;
        Ok(Self { recording, masses, origin })
    }

    /// What is known of the recording, without its samples.
    #[must_use]
    pub fn clone_without_samples(&self) -> Self {
        Self { recording: self.recording.without_samples(), ..*self }
    }
}
