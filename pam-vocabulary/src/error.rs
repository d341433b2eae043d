//! Errors of effects that are written by name.

use std::fmt;

/// An effect or one of its values is unknown, missing or impossible.
#[derive(Debug, Clone, PartialEq)]
pub enum VocabularyError {
    /// No effect has this id.
    UnknownEffect {
        /// The id as written.
        id: String,
        /// The known ids.
        known: Vec<&'static str>,
    },
    /// The effect has no parameter or switch of this name.
    UnknownValue {
        /// The effect.
        effect: &'static str,
        /// The name as written.
        name: String,
        /// Names of the effect's parameters and switches.
        known: Vec<&'static str>,
    },
    /// A parameter is not given.
    Missing {
        /// The effect.
        effect: &'static str,
        /// The parameter.
        name: &'static str,
    },
    /// A value is outside its range, or not a number.
    OutsideRange {
        /// The effect.
        effect: &'static str,
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The range.
        range: [f64; 2],
    },
    /// The text of an effect cannot be read.
    Text {
        /// The effect as written.
        effect: String,
        /// The problem.
        message: String,
    },
}

impl VocabularyError {
    /// [`VocabularyError::UnknownEffect`] with the known ids.
    pub fn unknown_effect(id: &str, known: impl IntoIterator<Item = &'static str>) -> Self {
        Self::UnknownEffect { id: id.to_owned(), known: known.into_iter().collect() }
    }

    /// [`VocabularyError::UnknownValue`] with the names that the effect has.
    pub fn unknown_value(
        effect: &'static str,
        name: &str,
        known: impl IntoIterator<Item = &'static str>,
    ) -> Self {
        Self::UnknownValue { effect, name: name.to_owned(), known: known.into_iter().collect() }
    }
}

impl fmt::Display for VocabularyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownEffect { id, known } => {
                write!(f, "there is no effect `{id}`; there are {}", known.join(", "))
            }
            Self::UnknownValue { effect, name, known } => {
                let known = known.join(", ");
                write!(f, "effect `{effect}`: no parameter `{name}`; it has {known}")
            }
            Self::Missing { effect, name } => write!(f, "effect `{effect}`: `{name}` is missing"),
            Self::OutsideRange { effect, name, value, range: [low, high] } => {
                write!(f, "effect `{effect}`: `{name}` = {value} is outside {low} … {high}")
            }
            Self::Text { effect, message } => write!(f, "effect `{effect}`: {message}"),
        }
    }
}

impl std::error::Error for VocabularyError {}
