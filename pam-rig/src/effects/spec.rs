//! An effect with the values of its parameters, and its text form.

use super::expression::{self, ExpressionEffect};
use super::timed::{Timed, Times};
use super::{ALL, EffectInfo, HiddenEffect, Phenomenon};
pub use pam_vocabulary::VocabularyError;
use pam_vocabulary::{ActivityWindow, course};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// An effect that is switched on, with the values of its parameters.
///
/// As text `coulomb_friction:force_n=20`, parameters separated by commas; as TOML a table with `id` and
/// the parameters. Without any parameter it takes its typical values. With `onset_s`, `ramp_s` and `end_s` among them it
/// begins, grows or ends at a time.
#[derive(Debug, Clone, Copy)]
pub struct Effect {
    source: Source,
    values: [f64; Effect::MOST],
    times: Times,
}

/// Where an effect comes from.
#[derive(Debug, Clone, Copy)]
enum Source {
    Rig(&'static HiddenEffect),
    File(&'static ExpressionEffect),
}

impl Source {
    /// The effect of the rig, or of a file that was read, with this id.
    fn of(id: &str) -> Result<Self, VocabularyError> {
        if let Some(hidden) = ALL.iter().find(|e| e.info.id == id) {
            return Ok(Self::Rig(hidden));
        }
        let known = expression::known();
        let found = known.iter().find(|e| e.info.id == id);
        found.map(|e| Self::File(e)).ok_or_else(|| {
            let ids = ALL.iter().map(|e| e.info.id).chain(known.iter().map(|e| e.info.id));
            VocabularyError::unknown_effect(id, ids)
        })
    }

    fn info(self) -> &'static EffectInfo {
        match self {
            Self::Rig(hidden) => hidden.info,
            Self::File(effect) => effect.info,
        }
    }

    /// Names of the values: the parameters, of a file also the switches.
    fn value_names(self) -> impl Iterator<Item = &'static str> {
        let switches = match self {
            Self::Rig(_) => &[],
            Self::File(effect) => effect.info.switches,
        };
        self.info().parameters.iter().map(|p| p.name).chain(switches.iter().map(|s| s.name))
    }

    /// The value of a parameter that is not given.
    fn default(self, k: usize, nothing_given: bool) -> Option<f64> {
        match self {
            Self::Rig(hidden) if nothing_given => Some(hidden.typical[k]),
            Self::Rig(hidden) => hidden.neutral(&hidden.info.parameters[k]),
            Self::File(effect) => {
                // A switch that is not mentioned is off.
                let Some(parameter) = effect.info.parameters.get(k) else { return Some(0.0) };
                parameter.off.filter(|_| !nothing_given)
            }
        }
    }
}

impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        self.id() == other.id()
            && self.values() == other.values()
            && self.times == other.times
            && self.definition() == other.definition()
    }
}

impl Effect {
    /// Most parameters that an effect may have.
    pub const MOST: usize = 16;

    /// An effect with some of its parameters by name.
    ///
    /// # Errors
    /// [`VocabularyError`] if the id or a name is unknown, a needed parameter is missing, or a value is
    /// outside its range.
    pub fn new(id: &str, given: &BTreeMap<String, f64>) -> Result<Self, VocabularyError> {
        Self::from_source(Source::of(id)?, given)
    }

    fn from_source(source: Source, given: &BTreeMap<String, f64>) -> Result<Self, VocabularyError> {
        let (effect, parameters) = (source.info().id, source.info().parameters);
        let names = || source.value_names();
        let is_own = |name: &String| names().any(|known| known == name);
        let (given, times): (BTreeMap<String, f64>, BTreeMap<String, f64>) =
            given.iter().map(|(name, v)| (name.clone(), *v)).partition(|(name, _)| is_own(name));
        if let Some(name) = times.keys().find(|n| !ActivityWindow::is_time(n)) {
            let more = course::ALL.iter().map(|p| p.name).filter(|t| !is_own(&(*t).to_owned()));
            return Err(VocabularyError::unknown_value(effect, name, names().chain(more)));
        }
        if ActivityWindow::of_names(times.keys().map(String::as_str)).is_none() {
            return Err(VocabularyError::Missing { effect, name: course::ONSET.name });
        }
        for p in course::ALL {
            if let Some(&value) = times.get(p.name)
                && !p.admits(value)
            {
                let (name, range) = (p.name, p.range);
                return Err(VocabularyError::OutsideRange { effect, name, value, range });
            }
        }
        let times = Times::of(&times);
        let mut values = [0.0; Self::MOST];
        for (k, (value, name)) in values.iter_mut().zip(names()).enumerate() {
            *value = given
                .get(name)
                .copied()
                .or_else(|| source.default(k, given.is_empty()))
                .ok_or(VocabularyError::Missing { effect, name })?;
            if let Some(p) = parameters.get(k)
                && !p.admits(*value)
            {
                let (value, range) = (*value, p.range);
                return Err(VocabularyError::OutsideRange { effect, name, value, range });
            }
        }
        Ok(Self { source, values, times })
    }

    /// Id of the effect.
    #[must_use]
    pub fn id(&self) -> &'static str {
        self.source.info().id
    }

    /// The file that defines it, if it is [an expression](expression).
    #[must_use]
    pub fn definition(&self) -> Option<&'static str> {
        match self.source {
            Source::Rig(_) => None,
            Source::File(effect) => Some(&effect.text),
        }
    }

    /// Values of the parameters, in their order.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values[..self.source.value_names().count()]
    }

    /// Names and values of the parameters, and of the times at which it begins, grows or ends.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.source.value_names().zip(self.values().iter().copied()).chain(self.times.values())
    }

    /// The phenomenon at the start of a run.
    #[must_use]
    pub fn start(&self) -> Box<dyn Phenomenon> {
        let inner = match self.source {
            Source::Rig(hidden) => (hidden.build)(self.values()),
            Source::File(effect) => effect.start(self.values()),
        };
        if self.times.always() { inner } else { Box::new(Timed { inner, times: self.times }) }
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
    /// The file that defines it, if the rig does not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    definition: Option<String>,
    #[serde(flatten)]
    parameters: BTreeMap<String, f64>,
}

impl Serialize for Effect {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let parameters = self.parameters().map(|(n, v)| (n.to_owned(), v)).collect();
        let definition = self.definition().map(str::to_owned);
        Table { id: self.id().to_owned(), definition, parameters }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Effect {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let table = Table::deserialize(deserializer)?;
        let source = match &table.definition {
            Some(text) => expression::of_definition(&table.id, text).map(Source::File),
            None => Source::of(&table.id),
        };
        source
            .and_then(|source| Self::from_source(source, &table.parameters))
            .map_err(serde::de::Error::custom)
    }
}
