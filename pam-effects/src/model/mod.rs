//! A hybrid model with effects as further parts.
//!
//! [`ExtendedModel`] is saved in the framework's model format (the effects stand in the metadata), loads from
//! it, predicts recordings like any model ([`Predictor`]), and has a gradient like any
//! ([`value_and_gradient`](ExtendedModel::value_and_gradient)). Its effects alone are fitted with
//! [`refit`](ExtendedModel::refit); network and effects are trained together by a trainer that knows them as an
//! [extension](crate::training).

mod predict;
mod without_effects;

pub use without_effects::WithoutEffects;

use crate::effects::{ALL, AnyEffect, VocabularyError, by_id};
use crate::error::EffectError;
use crate::simulation::Base;
use pam_core::{AnyForce, JointModel};
use pam_data::{ModelInfo, SavedModel, StoredEffect};

#[cfg(doc)]
use pam_trajectory::Predictor;

/// An effect that is switched on, with its values: parameters, then switches.
#[derive(Debug, Clone)]
pub struct ActiveEffect {
    /// The effect.
    pub effect: &'static dyn AnyEffect,
    /// Its values.
    pub values: Vec<f64>,
}

impl ActiveEffect {
    /// The values by name, as they are stored.
    #[must_use]
    pub fn stored(&self) -> StoredEffect {
        let info = self.effect.info();
        StoredEffect {
            effect: info.id.into(),
            values: info
                .value_names()
                .map(str::to_owned)
                .zip(self.values.iter().copied())
                .collect(),
        }
    }

    /// An effect from its stored form, looked up among `known`.
    ///
    /// # Errors
    /// [`EffectError::Vocabulary`] if there is no such effect, or a value is missing, unknown or not finite.
    pub fn from_stored(
        stored: &StoredEffect,
        known: &[&'static dyn AnyEffect],
    ) -> Result<Self, EffectError> {
        let effect = known
            .iter()
            .find(|e| e.info().id == stored.effect)
            .copied()
            .or_else(|| by_id(&stored.effect))
            .ok_or_else(|| {
                VocabularyError::unknown_effect(&stored.effect, known.iter().map(|e| e.info().id))
            })?;
        let info = effect.info();
        if let Some(name) = stored.values.keys().find(|k| info.value_names().all(|n| n != **k)) {
            return Err(VocabularyError::unknown_value(info.id, name, info.value_names()).into());
        }
        let value = |name| match stored.values.get(name) {
            Some(v) if v.is_finite() => Ok(*v),
            Some(v) => Err(VocabularyError::OutsideRange {
                effect: info.id,
                name,
                value: *v,
                range: [f64::NEG_INFINITY, f64::INFINITY],
            }),
            // A switch that is not mentioned is off.
            None if info.switches.iter().any(|s| s.name == name) => Ok(0.0),
            None => Err(VocabularyError::Missing { effect: info.id, name }),
        };
        let values = info.value_names().map(value).collect::<Result<Vec<f64>, _>>()?;
        Ok(Self { effect, values })
    }
}

/// A hybrid model with effects.
#[derive(Debug, Clone)]
pub struct ExtendedModel {
    /// The model without effects.
    pub joint: JointModel<f64, AnyForce<f64>>,
    /// What is known of it.
    pub info: ModelInfo,
    /// The effects, in the order in which they act.
    pub effects: Vec<ActiveEffect>,
}

impl ExtendedModel {
    /// A model from its file, with effects of the vocabulary.
    ///
    /// # Errors
    /// [`EffectError::Vocabulary`] if the file has an effect that is not known.
    pub fn from_saved(saved: SavedModel) -> Result<Self, EffectError> {
        let effects: Result<Vec<_>, _> =
            saved.info.effects.iter().map(|e| ActiveEffect::from_stored(e, ALL)).collect();
        Ok(Self { effects: effects?, joint: saved.model, info: saved.info })
    }

    /// The model as it is saved.
    #[must_use]
    pub fn to_saved(&self) -> SavedModel {
        let mut info = self.info.clone();
        info.effects = self.effects.iter().map(ActiveEffect::stored).collect();
        SavedModel { model: self.joint.clone(), info }
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

/// A number to so many significant digits.
#[must_use]
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let places = (digits - 1 - value.abs().log10().floor() as i32).clamp(0, 12);
    format!("{value:.*}", places as usize)
}
