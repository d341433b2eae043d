//! TOML files whose errors name file and line.

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
    toml::from_str(text).map_err(|e: toml::de::Error| {
        let offset = e.span().map_or(0, |span| span.start);
        DataError::line(path, line_of(text, offset), e.message().replace('\n', "; "))
    })
}

/// The value that a table holds.
///
/// It is read from the text of the table: types that are read from files and from tables are then compiled for one
/// reader only.
///
/// # Errors
/// What is wrong, without a line.
pub fn from_table<T: DeserializeOwned>(table: &toml::Table) -> Result<T, String> {
    toml::from_str(&table.to_string()).map_err(|e| e.message().to_owned())
}
