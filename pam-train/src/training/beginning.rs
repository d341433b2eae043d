//! The start of a run: the model, and recordings with their masses.

use super::error::TrainingError;
use crate::curriculum::{Curriculum, Selection, StartModel};
use crate::warm_start::random_network;
use pam_core::{Activation, AnyForce, JointModel};
use pam_data::Subject;
use pam_data::{MassChoice, MassOrigin, MuscleSurfaces, Recording, load_model};
use pam_trajectory::engine::NetworkJoint;

/// The recordings of a selection.
pub(super) fn select<'s>(
    subjects: &'s [Subject],
    selection: Option<&Selection>,
) -> impl Iterator<Item = &'s Subject> {
    let takes = move |s: &&Subject| {
        selection.is_none_or(|selection| selection.takes(&s.recording.name, true))
    };
    subjects.iter().filter(takes)
}

/// Computes anew the masses that come from the gas law.
pub(super) fn update_masses(
    subjects: &mut [Subject],
    model: &NetworkJoint,
    surfaces: Option<&MuscleSurfaces>,
) -> Result<(), TrainingError> {
    for s in subjects.iter_mut().filter(|s| s.origin == MassOrigin::GasLaw) {
        (s.masses, s.origin) =
            pam_data::resolve_masses(&s.recording, model, true, MassChoice::Auto, surfaces)?;
    }
    Ok(())
}

/// A recording with its masses.
pub(super) fn subject(
    recording: Recording,
    model: &NetworkJoint,
    trained: bool,
    surfaces: Option<&MuscleSurfaces>,
) -> Result<Subject, TrainingError> {
    let (masses, origin) =
        pam_data::resolve_masses(&recording, model, trained, MassChoice::Auto, surfaces)?;
    Ok(Subject { recording, masses, origin })
}

/// The model that training starts from.
pub(super) struct Start {
    pub(super) model: NetworkJoint,
    /// Whether its gas law is worth more than surfaces.
    pub(super) trained: bool,
    /// Whether its weights are those between scaled inputs and a scaled output, as random ones are.
    pub(super) scaled_weights: bool,
}

impl Start {
    /// The start of a curriculum; `extended` if the effects that it names are trained.
    pub(super) fn of(
        curriculum: &Curriculum,
        extended: bool,
        seed: u64,
    ) -> Result<Self, TrainingError> {
        let settings = &curriculum.model;
        if !(extended || settings.effects.is_empty()) {
            return Err(TrainingError::Curriculum(
                "model.effects: this command trains no effects; `pam train` does".into(),
            ));
        }
        let path = match &settings.start {
            StartModel::Random => {
                let activation = Activation::from_name(&settings.activation)?;
                let force =
                    random_network(&settings.hidden, activation, settings.initialisation, seed)?;
                let model = match &settings.rig {
                    Some(rig) => rig.model(force),
                    None => JointModel::datasheet(force),
                };
                return Ok(Self { model, trained: false, scaled_weights: true });
            }
            StartModel::File(path) => path,
        };
        let saved = load_model(path)?;
        if !(extended || saved.info.effects.is_empty()) {
            return Err(TrainingError::Curriculum(format!(
                "{} is extended by effects, which this command does not train; `pam train` does, and \
                 `pam convert --plain` makes a plain model of it",
                path.display()
            )));
        }
        let AnyForce::Network(force) = &saved.model.force else {
            return Err(TrainingError::Curriculum(format!(
                "{} holds no network to train",
                path.display()
            )));
        };
        let model = saved.model.map(|v| v, |_| force.clone());
        Ok(Self { model, trained: saved.info.trained, scaled_weights: false })
    }
}
