//! The form in which effects stand in files.

use super::ActiveEffect;
use crate::effects::{AnyEffect, VocabularyError, by_id};
use crate::error::EffectError;
use pam_data::ModelInfo;
use serde::{Deserialize, Serialize, Serializer};
use std::collections::BTreeMap;

/// An effect of an extended model in the metadata of a model file and in curricula.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectRecord {
    /// Id of the effect.
    pub effect: String,
    /// Its values by name, with units in the names.
    pub values: BTreeMap<String, f64>,
}

impl EffectRecord {
    /// The effects in the metadata of a model.
    ///
    /// # Errors
    /// [`EffectError::Effect`] if an entry is not of this form.
    pub fn all_of(info: &ModelInfo) -> Result<Vec<Self>, EffectError> {
        let read = |entry: &serde_json::Value| {
            Self::deserialize(entry).map_err(|e| EffectError::Effect {
                id: entry["effect"].as_str().unwrap_or("?").to_owned(),
                message: format!("metadata `effects` cannot be read: {e}"),
            })
        };
        info.effects.iter().map(read).collect()
    }

    /// The effect with its values; its id is looked up among `known` and then in the vocabulary.
    ///
    /// # Errors
    /// [`EffectError::Vocabulary`] if there is no such effect, or a value is missing, unknown or not finite.
    pub fn resolve(&self, known: &[&'static dyn AnyEffect]) -> Result<ActiveEffect, EffectError> {
        let effect = known
            .iter()
            .find(|e| e.info().id == self.effect)
            .copied()
            .or_else(|| by_id(&self.effect))
            .ok_or_else(|| {
                VocabularyError::unknown_effect(&self.effect, known.iter().map(|e| e.info().id))
            })?;
        let info = effect.info();
        if let Some(name) = self.values.keys().find(|k| info.value_names().all(|n| n != **k)) {
            return Err(VocabularyError::unknown_value(info.id, name, info.value_names()).into());
        }
        let value = |name| match self.values.get(name) {
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
        Ok(ActiveEffect { effect, values })
    }
}

impl From<&ActiveEffect> for EffectRecord {
    fn from(active: &ActiveEffect) -> Self {
        let info = active.effect.info();
        let names = info.value_names().map(str::to_owned);
        Self { effect: info.id.into(), values: names.zip(active.values.iter().copied()).collect() }
    }
}

/// As an [`EffectRecord`].
impl Serialize for ActiveEffect {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        EffectRecord::from(self).serialize(serializer)
    }
}
