//! An effect with the values of its parameters, and its text form.

use super::{ALL, HiddenEffect, Phenomenon};
pub use pam_vocabulary::VocabularyError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// An effect that is switched on, with the values of its parameters.
///
/// As text `coulomb_friction:force_n=20`, parameters separated by commas; as TOML a table with `id` and
/// the parameters. Without any parameter it takes its typical values.
#[derive(Debug, Clone, Copy)]
pub struct Effect {
    hidden: &'static HiddenEffect,
    values: [f64; Effect::MOST],
}

impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        self.id() == other.id() && self.values() == other.values()
    }
}

impl Effect {
    /// Most parameters that an effect may have.
    pub const MOST: usize = 4;

    /// An effect with some of its parameters by name.
    ///
    /// # Errors
    /// [`VocabularyError`] if the id or a name is unknown, a needed parameter is missing, or a value is
    /// outside its range.
    pub fn new(id: &str, given: &BTreeMap<String, f64>) -> Result<Self, VocabularyError> {
        let hidden = ALL
            .iter()
            .find(|e| e.info.id == id)
            .ok_or_else(|| VocabularyError::unknown_effect(id, ALL.iter().map(|e| e.info.id)))?;
        let (effect, parameters) = (hidden.info.id, hidden.info.parameters);
        let names = || parameters.iter().map(|p| p.name);
        if let Some(name) = given.keys().find(|n| names().all(|known| known != **n)) {
            return Err(VocabularyError::unknown_value(effect, name, names()));
        }
        let mut values = [0.0; Self::MOST];
        for ((value, p), typical) in values.iter_mut().zip(parameters).zip(hidden.typical) {
            let default = if given.is_empty() { Some(*typical) } else { hidden.neutral(p) };
            *value = given
                .get(p.name)
                .copied()
                .or(default)
                .ok_or(VocabularyError::Missing { effect, name: p.name })?;
            if !p.admits(*value) {
                let (name, value, range) = (p.name, *value, p.range);
                return Err(VocabularyError::OutsideRange { effect, name, value, range });
            }
        }
        Ok(Self { hidden, values })
    }

    /// Id of the effect.
    #[must_use]
    pub fn id(&self) -> &'static str {
        self.hidden.info.id
    }

    /// Values of the parameters, in their order.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values[..self.hidden.info.parameters.len()]
    }

    /// Names and values of the parameters.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.hidden.info.parameters.iter().map(|p| p.name).zip(self.values().iter().copied())
    }

    /// The phenomenon at the start of a run.
    #[must_use]
    pub fn start(&self) -> Box<dyn Phenomenon> {
        (self.hidden.build)(self.values())
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())?;
        for (i, (name, value)) in self.parameters().enumerate() {
            write!(f, "{}{name}={value}", if i == 0 { ':' } else { ',' })?;
        }
        Ok(())
    }
}

impl FromStr for Effect {
    type Err = VocabularyError;

    fn from_str(text: &str) -> Result<Self, VocabularyError> {
        let (id, rest) = text.split_once(':').unwrap_or((text, ""));
        let fail =
            |message: String| VocabularyError::Text { effect: id.trim().to_owned(), message };
        let mut given = BTreeMap::new();
        for part in rest.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let (name, value) = part
                .split_once('=')
                .ok_or_else(|| fail(format!("`{part}` is not of the form name=value")))?;
            let number = value
                .trim()
                .parse::<f64>()
                .map_err(|_| fail(format!("`{}` in `{part}` is not a number", value.trim())))?;
            if given.insert(name.trim().to_owned(), number).is_some() {
                return Err(fail(format!("`{}` is given twice", name.trim())));
            }
        }
        Self::new(id.trim(), &given)
    }
}

/// The table form.
#[derive(Serialize, Deserialize)]
struct Table {
    id: String,
    #[serde(flatten)]
    parameters: BTreeMap<String, f64>,
}

impl Serialize for Effect {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let parameters = self.parameters().map(|(n, v)| (n.to_owned(), v)).collect();
        Table { id: self.id().to_owned(), parameters }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Effect {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let table = Table::deserialize(deserializer)?;
        Self::new(&table.id, &table.parameters).map_err(serde::de::Error::custom)
    }
}
