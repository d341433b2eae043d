//! Options whose value is one of the names that the library knows.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use pam_core::{ModelError, NamedChoice};

/// Names and descriptions of a choice of the library.
pub(crate) fn possible_values<T: NamedChoice>() -> impl Iterator<Item = PossibleValue> {
    T::ALL.iter().map(|(name, _, description)| {
        PossibleValue::new(*name).help(*description).alias(name.replace('-', "_"))
    })
}

/// Parser of a choice of the library, with `possible_values`. Underscores may stand for hyphens.
pub fn choice<T: NamedChoice>() -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(possible_values::<T>())
        .try_map(|name| T::from_name(&name.replace('_', "-")))
}

/// Parser of a value that the library knows by one of `names`.
pub fn named<T: Clone + Send + Sync + 'static>(
    names: Vec<&'static str>,
    from_name: fn(&str) -> Result<T, ModelError>,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(names).try_map(move |name| from_name(&name))
}
