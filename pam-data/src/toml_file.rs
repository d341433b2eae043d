//! TOML files whose errors name file and line.

use crate::document;
use crate::error::DataError;
use serde::de::DeserializeOwned;
use std::path::Path;

/// The text of a file.
///
/// # Errors
/// [`DataError::Io`].
pub fn text(path: &Path) -> Result<String, DataError> {
    std::fs::read_to_string(path).map_err(|e| DataError::io(path, e))
}

/// The line, counted from one, of a byte offset.
#[must_use]
pub fn line_of(text: &str, offset: usize) -> u64 {
    1 + text.bytes().take(offset).filter(|&b| b == b'\n').count() as u64
}

/// Reads a value from TOML text; `path` is for messages.
///
/// # Errors
/// [`DataError::Line`].
pub fn parse<T: DeserializeOwned>(text: &str, path: &Path) -> Result<T, DataError> {
    document::from_toml(text)
        .map_err(|e| DataError::line(path, e.line(text), e.message().replace('\n', "; ")))
}

/// The value of an assignment on a command line, written as TOML writes it; `None` if it is none.
#[must_use]
pub fn single_value(text: &str) -> Option<toml::Value> {
    table(&format!("v = {text}")).ok()?.remove("v")
}

/// The table that TOML text holds.
///
/// # Errors
/// What is wrong, without a line.
pub fn table(text: &str) -> Result<toml::Table, String> {
    document::from_toml(text).map_err(|e| e.to_string())
}

/// The value that a table holds.
///
/// # Errors
/// What is wrong, without a line.
pub fn from_table<T: DeserializeOwned>(table: &toml::Table) -> Result<T, String> {
    document::from_toml(&table.to_string()).map_err(|e| e.to_string())
}
