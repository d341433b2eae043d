//! An effect with its parameters, as people write it.

use super::{ALL, EffectInfo, Phenomenon};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// What is wrong with an effect as written.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum EffectError {
    /// No effect has this id.
    #[error("there is no effect `{id}`; there are {}", ALL.iter().map(|e| e.id).collect::<Vec<_>>().join(", "))]
    Unknown {
        /// The id as written.
        id: String,
    },
    /// A parameter is missing, unknown, or out of its limits.
    #[error("effect `{id}`: {message}")]
    Parameter {
        /// The effect.
        id: String,
        /// What is wrong and what to do.
        message: String,
    },
}

/// An effect that is switched on: its id and the values of its parameters.
///
/// As text `coulomb_friction:force_n=20`, parameters separated by commas; as TOML a table with `id` and
/// the parameters. Without any parameter the typical values are taken.
#[derive(Debug, Clone, Copy)]
pub struct Effect {
    info: &'static EffectInfo,
    values: [f64; Effect::MOST],
}

impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        self.info.id == other.info.id && self.values() == other.values()
    }
}

impl Effect {
    const MOST: usize = 4;

    /// An effect with some parameters by name.
    ///
    /// # Errors
    /// [`EffectError`] if the id or a name is unknown, a needed parameter is missing, or a value is
    /// outside its limits.
    pub fn new(id: &str, given: &BTreeMap<String, f64>) -> Result<Self, EffectError> {
        let info = ALL
            .iter()
            .find(|e| e.id == id)
            .ok_or_else(|| EffectError::Unknown { id: id.to_owned() })?;
        let fail = |message: String| EffectError::Parameter { id: id.to_owned(), message };
        let names = || info.parameters.iter().map(|p| p.name).collect::<Vec<_>>().join(", ");
        if let Some(name) = given.keys().find(|n| info.parameters.iter().all(|p| p.name != **n)) {
            return Err(fail(format!("no parameter `{name}`; it has {}", names())));
        }
        let mut values = [0.0; Self::MOST];
        for (value, p) in values.iter_mut().zip(info.parameters) {
            *value = match (given.get(p.name), p.neutral) {
                (Some(v), _) => *v,
                (None, _) if given.is_empty() => p.typical,
                (None, Some(neutral)) => neutral,
                (None, None) => {
                    return Err(fail(format!("`{}` is missing; it has {}", p.name, names())));
                }
            };
            let [low, high] = p.limits;
            if !(low..=high).contains(value) {
                return Err(fail(format!("`{}` = {value} is outside {low} … {high}", p.name)));
            }
        }
        Ok(Self { info, values })
    }

    /// What is known of the effect.
    #[must_use]
    pub fn info(&self) -> &'static EffectInfo {
        self.info
    }

    /// Values of the parameters, in their order.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values[..self.info.parameters.len()]
    }

    /// Names and values of the parameters.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.info.parameters.iter().map(|p| p.name).zip(self.values().iter().copied())
    }

    /// The phenomenon at the start of a run.
    #[must_use]
    pub fn start(&self) -> Box<dyn Phenomenon> {
        (self.info.build)(self.values())
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.info.id)?;
        for (i, (name, value)) in self.parameters().enumerate() {
            write!(f, "{}{name}={value}", if i == 0 { ':' } else { ',' })?;
        }
        Ok(())
    }
}

impl FromStr for Effect {
    type Err = EffectError;

    fn from_str(text: &str) -> Result<Self, EffectError> {
        let (id, rest) = text.split_once(':').unwrap_or((text, ""));
        let fail = |message: String| EffectError::Parameter { id: id.trim().to_owned(), message };
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
        Table { id: self.info.id.to_owned(), parameters }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Effect {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let table = Table::deserialize(deserializer)?;
        Self::new(&table.id, &table.parameters).map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_table_say_the_same() {
        let effect: Effect = "leak: flexor_rate_per_s = 0.01".parse().unwrap();
        assert_eq!(effect.values(), [0.01, 0.0]);
        assert_eq!(effect.to_string().parse::<Effect>().unwrap(), effect);
        let json = serde_json::to_string(&effect).unwrap();
        assert_eq!(serde_json::from_str::<Effect>(&json).unwrap(), effect);
    }

    #[test]
    fn every_effect_takes_its_typical_values_within_its_limits() {
        for info in ALL {
            let effect: Effect = info.id.parse().unwrap();
            assert!(info.parameters.len() <= Effect::MOST);
            assert_eq!(effect.to_string().parse::<Effect>().unwrap(), effect);
            let _ = effect.start();
        }
    }

    #[test]
    fn what_is_wrong_is_said() {
        let message = |text: &str| text.parse::<Effect>().unwrap_err().to_string();
        assert!(message("coulomb").contains("coulomb_friction, stribeck_friction"));
        assert!(message("creep:stiffness_n_mm=10").contains("`time_constant_s` is missing"));
        assert!(message("creep:stiffness=10").contains("no parameter `stiffness`"));
        assert!(message("backlash:gap_mm=-1").contains("outside 0"));
        assert!(message("backlash:gap_mm=x").contains("not a number"));
        assert!(message("backlash:gap_mm").contains("name=value"));
    }
}
