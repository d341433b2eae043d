//! Errors of files.

use std::path::{Path, PathBuf};
use thiserror::Error;

/// A file that cannot be read, understood or used.
#[derive(Debug, Error)]
pub enum DataError {
    /// The operating system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A place in a text file is wrong.
    #[error("{}:{line}: column `{column}`: {message}", path.display())]
    Cell {
        /// The file.
        path: PathBuf,
        /// Line, counted from one.
        line: u64,
        /// Name of the column.
        column: String,
        /// The problem and its remedy.
        message: String,
    },
    /// A line of a text file is wrong.
    #[error("{}:{line}: {message}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Line, counted from one.
        line: u64,
        /// The problem and its remedy.
        message: String,
    },
    /// The file as a whole is wrong.
    #[error("{}: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The problem and its remedy.
        message: String,
    },
}

impl DataError {
    /// What is wrong, with line and column but without the file.
    #[must_use]
    pub fn fault(&self) -> String {
        match self {
            Self::Io { source, .. } => source.to_string(),
            Self::Cell { line, column, message, .. } => {
                format!("line {line}: column `{column}`: {message}")
            }
            Self::Line { line, message, .. } => format!("line {line}: {message}"),
            Self::File { message, .. } => message.clone(),
        }
    }

    /// Whether the fault is that there is no such file.
    #[must_use]
    pub fn is_missing(&self) -> bool {
        matches!(self, Self::Io { source, .. } if source.kind() == std::io::ErrorKind::NotFound)
    }

    /// The operating system refused to read or write a file.
    #[must_use]
    pub fn io(path: impl AsRef<Path>, source: std::io::Error) -> Self {
        let path = path.as_ref();
        Self::Io { path: path.to_owned(), source }
    }

    /// A file is wrong as a whole.
    #[must_use]
    pub fn file(path: impl AsRef<Path>, message: impl Into<String>) -> Self {
        let path = path.as_ref();
        Self::File { path: path.to_owned(), message: message.into() }
    }

    /// A line of a text file, counted from one, is wrong.
    #[must_use]
    pub fn line(path: impl AsRef<Path>, line: u64, message: impl Into<String>) -> Self {
        let path = path.as_ref();
        Self::Line { path: path.to_owned(), line, message: message.into() }
    }

    /// A cell of a text file, by line (counted from one) and column, is wrong.
    #[must_use]
    pub fn cell(
        path: impl AsRef<Path>,
        line: u64,
        column: &str,
        message: impl Into<String>,
    ) -> Self {
        let path = path.as_ref();
        Self::Cell {
            path: path.to_owned(),
            line,
            column: column.to_owned(),
            message: message.into(),
        }
    }
}

pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, DataError> {
    crate::read_limit::read(path)
}
