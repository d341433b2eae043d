//! TOML files whose errors name file and line.

use crate::error::RigError;
use pam_data::DataError;
use serde::de::DeserializeOwned;
use std::path::Path;

/// The text of a file.
pub(crate) fn text(path: &Path) -> Result<String, RigError> {
    std::fs::read_to_string(path)
        .map_err(|source| DataError::Io { path: path.to_owned(), source }.into())
}

/// The line (from one) of a byte offset.
pub(crate) fn line_of(text: &str, offset: usize) -> usize {
    1 + text.as_bytes().iter().take(offset).filter(|&&b| b == b'\n').count()
}

/// Reads a value from TOML text.
pub(crate) fn parse<T: DeserializeOwned>(text: &str, path: &Path) -> Result<T, RigError> {
    toml::from_str(text).map_err(|e| RigError::File {
        path: path.to_owned(),
        line: e.span().map_or(1, |span| line_of(text, span.start)),
        message: e.message().replace('\n', "; "),
    })
}
