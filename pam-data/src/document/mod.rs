//! Values in TOML and JSON files: one reader and one writer for both.
//!
//! `serde` compiles a type again for each format that it is read from or written to, and the reader of TOML takes
//! four forms of each table. Settings with hundreds of fields are most of what several crates would compile. Here a
//! file of either format becomes a [`Node`] first, and values are read from nodes alone; values become a
//! [`serde_json::Value`] first, from which the text of either format is written.
//!
//! Numbers keep every bit: texts hold the shortest decimal that reads back as the same number.

mod deserialize;
mod node;

pub use deserialize::DocumentError;
pub use node::Node;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Reads a value from TOML text.
///
/// # Errors
/// [`DocumentError`] with what is wrong and where.
pub fn from_toml<T: DeserializeOwned>(text: &str) -> Result<T, DocumentError> {
    T::deserialize(Node::from_toml(text)?)
}

/// Reads a value from JSON text.
///
/// # Errors
/// [`DocumentError`] with what is wrong and the field.
pub fn from_json<T: DeserializeOwned>(text: &str) -> Result<T, DocumentError> {
    T::deserialize(Node::from_json(text)?)
}

/// Reads a value from a JSON value.
///
/// # Errors
/// [`DocumentError`] with what is wrong and the field.
pub fn from_value<T: DeserializeOwned>(value: Value) -> Result<T, DocumentError> {
    T::deserialize(Node::from(value))
}

/// The value as TOML text: a table whose absent options are left out.
///
/// # Errors
/// What TOML cannot hold: a value that is no table, or an absent value in a list.
pub fn to_toml<T: Serialize>(value: &T) -> Result<String, DocumentError> {
    let mut value = serde_json::to_value(value)?;
    remove_nulls(&mut value);
    toml::to_string(&value).map_err(|e| DocumentError::new(e.to_string()))
}

/// The value as JSON text in one line.
///
/// # Errors
/// What JSON cannot hold: maps whose keys are neither texts nor integers.
pub fn to_json<T: Serialize>(value: &T) -> Result<String, DocumentError> {
    Ok(serde_json::to_value(value)?.to_string())
}

/// TOML has no null; a field without value is left out.
fn remove_nulls(value: &mut Value) {
    match value {
        Value::Object(map) => {
            map.retain(|_, v| !v.is_null());
            map.values_mut().for_each(remove_nulls);
        }
        Value::Array(list) => list.iter_mut().for_each(remove_nulls),
        _ => {}
    }
}

#[cfg(test)]
mod tests;
