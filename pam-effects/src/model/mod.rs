//! A hybrid model with effects as further parts.
//!
//! [`ExtendedModel`] is saved in the framework's model format (each effect is an [`EffectRecord`] in the
//! metadata), loads from it, predicts recordings like any model ([`Predictor`]), and has a gradient like any
//! ([`value_and_gradient`](ExtendedModel::value_and_gradient)). The diagnosis fits its effects alone; the trainer
//! trains network and effects together.

mod active;
mod predict;
mod record;
mod without_effects;

pub use active::ActiveEffect;
pub use pam_core::units::significant;
pub use record::EffectRecord;
pub use without_effects::WithoutEffects;

use crate::effects::AnyEffect;
use crate::error::EffectError;
use crate::simulation::Base;
use pam_core::{AnyForce, JointModel};
use pam_data::{ModelInfo, SavedModel};

#[cfg(doc)]
use pam_trajectory::Predictor;

/// A hybrid model with effects.
///
/// ```
/// use pam_core::{AnyForce, JointModel, SpringDamper};
/// use pam_data::{ModelInfo, Recording, Subject};
/// use pam_effects::effects::by_id;
/// use pam_effects::{ActiveEffect, ExtendedModel};
/// use pam_trajectory::{Predictor, SolverSettings};
///
/// let joint = JointModel::datasheet(AnyForce::from(SpringDamper::published()));
/// let model = ExtendedModel { joint, info: ModelInfo::default(), effects: Vec::new() };
/// let friction = ActiveEffect { effect: by_id("coulomb_friction").expect("listed"), values: vec![150.0] };
/// let rough = model.with([friction]); // 150 N of dry friction
///
/// let time_s = (0..500).map(|k| 2e-3 * f64::from(k)).collect();
/// let pushed = Recording::at_rest("a", time_s, [412.0, 412.0]).with_force(|_t| 1e5); // 100 N
/// let subject = Subject::of(pushed, &model.joint)?;
/// let end_mm = |model: &ExtendedModel| {
///     let predicted = model.predict(&subject.recording, subject.masses, &SolverSettings::default());
///     predicted.map(|p| p.channels.x[499])
/// };
/// assert!(end_mm(&model)? > 0.5);
/// assert!(end_mm(&rough)?.abs() < 0.01); // the friction holds the joint
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct ExtendedModel {
    /// The model without effects.
    pub joint: JointModel<f64, AnyForce<f64>>,
    /// Name, provenance and training data.
    pub info: ModelInfo,
    /// The effects, in the order in which they act.
    pub effects: Vec<ActiveEffect>,
}

impl ExtendedModel {
    /// A model from its file, with effects that this process knows: the built-in ones and those that were
    /// [registered](crate::effects::register).
    ///
    /// # Errors
    /// [`EffectError::Unknown`] if the file has an effect that is not known, [`EffectError::Vocabulary`] if a value of one
    /// is missing, unknown or not finite.
    pub fn from_saved(saved: SavedModel) -> Result<Self, EffectError> {
        Self::from_saved_among(saved, &[])
    }

    /// A model from its file, with effects of `known` or any that this process knows.
    ///
    /// # Errors
    /// As [`from_saved`](Self::from_saved).
    pub fn from_saved_among(
        saved: SavedModel,
        known: &[&'static dyn AnyEffect],
    ) -> Result<Self, EffectError> {
        let records = EffectRecord::all_of(&saved.info)?;
        let effects: Result<Vec<_>, _> = records.iter().map(|r| r.resolve(known)).collect();
        Ok(Self { effects: effects?, joint: saved.model, info: saved.info })
    }

    /// The model as it is saved.
    #[must_use]
    pub fn to_saved(&self) -> SavedModel {
        let mut info = self.info.clone();
        info.effects = self.effects.iter().map(|a| serde_json::json!(a)).collect();
        SavedModel { model: self.joint.clone(), info }
    }

    /// The parameters of the effects in turn.
    #[must_use]
    pub fn parameters(&self) -> Vec<f64> {
        self.effects.iter().flat_map(ActiveEffect::parameters).copied().collect()
    }

    /// The model with more effects behind those that it has.
    #[must_use]
    pub fn with(&self, more: impl IntoIterator<Item = ActiveEffect>) -> Self {
        let mut extended = self.clone();
        extended.effects.extend(more);
        extended
    }

    /// The joint's own numbers.
    #[must_use]
    pub fn base(&self) -> Base<f64> {
        Base::of(&self.joint)
    }

    /// Effects and values as a search takes them.
    #[must_use]
    pub fn parts(&self) -> Vec<(&'static dyn AnyEffect, Vec<f64>)> {
        self.effects.iter().map(|a| (a.effect, a.values.clone())).collect()
    }

    /// The effects in one line, `coulomb_friction (force_n = 41.2)`; empty without effects.
    #[must_use]
    pub fn describe_effects(&self) -> String {
        let one = |a: &ActiveEffect| {
            let values = a.effect.info().parameters.iter().zip(&a.values);
            let values: Vec<String> =
                values.map(|(p, v)| format!("{} = {}", p.name, significant(*v, 4))).collect();
            format!("{} ({})", a.effect.info().id, values.join(", "))
        };
        self.effects.iter().map(one).collect::<Vec<_>>().join(", ")
    }
}
