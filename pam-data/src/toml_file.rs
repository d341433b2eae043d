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
    toml::from_str(text).map_err(|e| fault(text, path, &e, 0))
}

/// The error of a deserialisation at its line, or at that of the byte `otherwise` where it has none.
#[must_use]
pub fn fault(text: &str, path: &Path, error: &toml::de::Error, otherwise: usize) -> DataError {
    let offset = error.span().map_or(otherwise, |span| span.start);
    DataError::line(path, line_of(text, offset), error.message().replace('\n', "; "))
}
