//! Reading TOML files, with file and line in errors.

use crate::document;
use crate::error::DataError;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Largest TOML file. A tree of values takes a few hundred times the memory of its text, and no settings are near this.
const MOST_BYTES: usize = 4 << 20;

/// Reads the text of a TOML file.
///
/// # Errors
/// [`DataError`] if the file cannot be read as UTF-8 (see [`read_limit`](crate::read_limit)), or is larger than any settings.
pub fn text(path: impl AsRef<Path>) -> Result<String, DataError> {
    let path = path.as_ref();
    let text = crate::read_limit::read_text(path)?;
    if text.len() > MOST_BYTES {
        let most = MOST_BYTES >> 20;
        let message = format!("too large for a TOML file of settings: at most {most} MiB are read");
        return Err(DataError::file(path, message));
    }
    Ok(text)
}

/// Deserializes TOML text; `path` appears in errors only.
///
/// # Errors
/// [`DataError::Line`] if the text is not TOML or does not match `T`.
pub fn parse<T: DeserializeOwned>(text: &str, path: impl AsRef<Path>) -> Result<T, DataError> {
    let path = path.as_ref();
    document::from_toml(text)
        .map_err(|e| DataError::line(path, e.line(text), e.message().replace('\n', "; ")))
}

/// Parses a command-line value written in TOML syntax; `None` if it is not valid TOML.
#[must_use]
pub fn single_value(text: &str) -> Option<toml::Value> {
    table(&format!("v = {text}")).ok()?.remove("v")
}

/// Parses TOML text as a table.
///
/// # Errors
/// The message of the [`DocumentError`](document::DocumentError) if the text is not TOML.
pub fn table(text: &str) -> Result<toml::Table, String> {
    document::from_toml(text).map_err(|e| e.to_string())
}

/// Deserializes a table.
///
/// # Errors
/// The message of the [`DocumentError`](document::DocumentError) if the table does not match `T`.
pub fn from_table<T: DeserializeOwned>(table: &toml::Table) -> Result<T, String> {
    document::from_toml(&table.to_string()).map_err(|e| e.to_string())
}

/// A value as TOML on one line, for `KEY=VALUE`.
///
/// # Errors
/// If TOML cannot represent the value.
pub fn inline<T: serde::Serialize>(value: &T) -> Result<String, String> {
    let text = document::to_toml(value).map_err(|e| e.to_string())?;
    Ok(toml::Value::Table(table(&text)?).to_string())
}
