//! Values in TOML and JSON files: one reader and one writer for both.
//!
//! serde instantiates the code of a type once per format, and the TOML deserializer once more for each of its four
//! kinds of table. For settings with hundreds of fields this dominates compile time. Here text of either format is
//! parsed into a [`Node`], and types are deserialized from nodes only; in the other direction they are serialized to
//! a [`serde_json::Value`], which is then printed as TOML or JSON.
//!
//! Floating-point numbers round-trip exactly: each is printed as the shortest decimal that reads back to the same bits.

mod deserialize;
mod node;

pub use deserialize::DocumentError;
pub use node::Node;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Deserializes a value from TOML text.
///
/// # Errors
/// [`DocumentError`] with the field and its position if the text is not TOML or does not match `T`.
pub fn from_toml<T: DeserializeOwned>(text: &str) -> Result<T, DocumentError> {
    T::deserialize(Node::from_toml(text)?)
}

/// Deserializes a value from JSON text.
///
/// # Errors
/// [`DocumentError`] with the field if the text is not JSON or does not match `T`.
pub fn from_json<T: DeserializeOwned>(text: &str) -> Result<T, DocumentError> {
    T::deserialize(Node::from_json(text)?)
}

/// Deserializes a value from a JSON value.
///
/// # Errors
/// [`DocumentError`] with the field if the value does not match `T`.
pub fn from_value<T: DeserializeOwned>(value: Value) -> Result<T, DocumentError> {
    T::deserialize(Node::from(value))
}

/// Serializes a value as TOML text. Fields that are `None` are omitted.
///
/// # Errors
/// If TOML cannot represent the value: it is not a table, or a list contains `None`.
pub fn to_toml<T: Serialize>(value: &T) -> Result<String, DocumentError> {
    let mut value = serde_json::to_value(value)?;
    remove_nulls(&mut value);
    toml::to_string(&value).map_err(|e| DocumentError::new(e.to_string()))
}

/// Serializes a value as JSON text on one line.
///
/// # Errors
/// If JSON cannot represent the value: a map key is neither a string nor an integer.
pub fn to_json<T: Serialize>(value: &T) -> Result<String, DocumentError> {
    Ok(serde_json::to_value(value)?.to_string())
}

/// TOML has no null, so fields without a value are removed.
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

/// The line, counted from one, that contains a byte offset.
#[must_use]
pub fn line_of(text: &str, offset: usize) -> u64 {
    1 + text.bytes().take(offset).filter(|&b| b == b'\n').count() as u64
}
