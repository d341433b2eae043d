//! The form in which effects stand in files.

use super::ActiveEffect;
use crate::effects::{self, ActivityWindow, AnyEffect, VocabularyError, by_id, timed};
use crate::error::EffectError;
use pam_data::ModelInfo;
use pam_vocabulary::course;
use serde::{Deserialize, Serialize, Serializer};
use std::collections::BTreeMap;
use std::str::FromStr;

/// An effect of an extended model in the metadata of a model file and in curricula.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectRecord {
    /// Id of the effect.
    pub effect: String,
    /// Its values by name, with units in the names; those of its [`ActivityWindow`] among them.
    pub values: BTreeMap<String, f64>,
    /// The file that defines it, if it is [an expression](crate::expression).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub definition: Option<String>,
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

    /// The error of an id that is neither among `known` nor known to this process.
    #[must_use]
    pub fn unknown(id: &str, known: &[&'static dyn AnyEffect]) -> EffectError {
        let mut ids: Vec<&str> = effects::all().into_iter().map(|e| e.info().id).collect();
        for effect in known {
            if !ids.contains(&effect.info().id) {
                ids.push(effect.info().id);
            }
        }
        EffectError::Unknown { id: id.to_owned(), known: ids }
    }

    /// The effect with its values: the one that [`definition`](Self::definition) defines, else its id is looked up among
    /// `known`, then among all that this process knows ([`by_id`]).
    ///
    /// # Errors
    /// [`EffectError::Unknown`] if there is no such effect, [`EffectError::Vocabulary`] if a value is missing, unknown or
    /// not finite, [`EffectError::File`] if the definition cannot be read.
    pub fn resolve(&self, known: &[&'static dyn AnyEffect]) -> Result<ActiveEffect, EffectError> {
        let effect = match &self.definition {
            Some(text) => crate::expression::of_definition(&self.effect, text)?,
            None => known
                .iter()
                .find(|e| e.info().id == self.effect)
                .copied()
                .or_else(|| by_id(&self.effect))
                .ok_or_else(|| Self::unknown(&self.effect, known))?,
        };
        let own: Vec<&str> = effect.info().value_names().collect();
        let times = self.values.keys().map(String::as_str).filter(|name| !own.contains(name));
        let course = ActivityWindow::of_names(times).ok_or_else(|| {
            let message = "`ramp_s` needs the `onset_s` about which it grows".to_owned();
            EffectError::Effect { id: self.effect.clone(), message }
        })?;
        let effect = timed(effect, course);
        let info = effect.info();
        if let Some(name) = self.values.keys().find(|k| info.value_names().all(|n| n != **k)) {
            let times = course::ALL.iter().map(|p| p.name).filter(|t| !own.contains(t));
            let names = own.iter().copied().chain(times);
            return Err(VocabularyError::unknown_value(info.id, name, names).into());
        }
        let value = |name| match self.values.get(name) {
            Some(v) if v.is_finite() => match info.parameters.iter().find(|p| p.name == name) {
                Some(p) if ActivityWindow::is_time(name) && !p.admits(*v) => {
                    let (effect, value, range) = (info.id, *v, p.range);
                    Err(VocabularyError::OutsideRange { effect, name, value, range })
                }
                _ => Ok(*v),
            },
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

/// Reads `ID:NAME=VALUE,…`, for example `coulomb_friction:force_n=12`, as command lines have it.
impl FromStr for EffectRecord {
    type Err = EffectError;

    fn from_str(text: &str) -> Result<Self, EffectError> {
        let (id, values) = text.split_once(':').unwrap_or((text, ""));
        let fail = |message: String| EffectError::Effect { id: id.trim().to_owned(), message };
        let mut record =
            Self { effect: id.trim().to_owned(), values: BTreeMap::new(), definition: None };
        for assignment in values.split(',').filter(|a| !a.trim().is_empty()) {
            let (name, value) = assignment.split_once('=').ok_or_else(|| {
                fail(format!("`{}` is not NAME=VALUE, like `force_n=12`", assignment.trim()))
            })?;
            let number: f64 = value.trim().parse().map_err(|_| {
                fail(format!("`{}` of `{}` is no number", value.trim(), name.trim()))
            })?;
            if record.values.insert(name.trim().to_owned(), number).is_some() {
                return Err(fail(format!("`{}` is given twice", name.trim())));
            }
        }
        Ok(record)
    }
}

impl From<&ActiveEffect> for EffectRecord {
    fn from(active: &ActiveEffect) -> Self {
        let info = active.effect.info();
        let names = info.value_names().map(str::to_owned);
        Self {
            effect: info.id.into(),
            values: names.zip(active.values.iter().copied()).collect(),
            definition: active.effect.definition().map(str::to_owned),
        }
    }
}

/// As an [`EffectRecord`].
impl Serialize for ActiveEffect {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        EffectRecord::from(self).serialize(serializer)
    }
}
