//! A recording with its sealed masses.

use crate::error::DataError;
use crate::masses::{MassChoice, MassOptions, MassOrigin, resolve_masses};
use crate::models::SavedModel;
use crate::recording::Recording;
use pam_core::{ForceModel, JointModel, SealedMasses};

/// Recordings with the masses that they give, or those of the model's gas law at their readings at rest: what predictions,
/// training losses and diagnoses start from. [`Subject::resolve`] has the choices of the commands.
///
/// ```
/// use pam_core::{JointModel, SpringDamper};
/// use pam_data::{Recording, subjects};
///
/// let model = JointModel::datasheet(SpringDamper::published());
/// let time_s = (0..500).map(|k| 2e-3 * f64::from(k)).collect();
/// let recording = Recording::at_rest("made up", time_s, [412.0, 412.0]); // kPa absolute
/// let subjects = subjects([recording], &model)?;
/// let sealed = model.gas_law_masses(0.0, [412.0, 412.0]); // at x = 0
/// assert!((subjects[0].masses.flexor_g / sealed.flexor_g - 1.0).abs() < 1e-12);
/// # Ok::<(), pam_data::DataError>(())
/// ```
///
/// # Errors
/// [`DataError`] naming the recording whose masses are not positive.
pub fn subjects<F: ForceModel<f64>>(
    recordings: impl IntoIterator<Item = Recording>,
    model: &JointModel<f64, F>,
) -> Result<Vec<Subject>, DataError> {
    recordings.into_iter().map(|recording| Subject::of(recording, model)).collect()
}

/// A recording with the masses to predict it with.
///
/// [`subjects`] makes them of recordings and has an example.
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

    /// Recordings with their masses for a saved model, as the commands find them; see [`resolve_masses`].
    ///
    /// ```no_run
    /// use pam_data::{LoadOptions, MassOptions, Subject, load_model, read_recordings};
    /// let saved = load_model("model.safetensors")?;
    /// let recordings = read_recordings(["logs"], &LoadOptions::default())?;
    /// let subjects = Subject::resolve(recordings, &saved, &MassOptions::default())?;
    /// # Ok::<(), pam_data::DataError>(())
    /// ```
    ///
    /// # Errors
    /// [`DataError`] naming the recording whose masses cannot be found.
    pub fn resolve(
        recordings: Vec<Recording>,
        saved: &SavedModel,
        options: &MassOptions,
    ) -> Result<Vec<Self>, DataError> {
        let (model, trained) = (&saved.model, saved.info.trained);
        let subject = |recording: Recording| {
            let surfaces = options.surfaces.as_ref();
            let (masses, origin) =
                resolve_masses(&recording, model, trained, options.choice, surfaces)?;
            Ok(Self { recording, masses, origin })
        };
        recordings.into_iter().map(subject).collect()
    }

    /// The recording without its samples, with its masses.
    #[must_use]
    pub fn clone_without_samples(&self) -> Self {
        Self { recording: self.recording.without_samples(), ..*self }
    }
}
