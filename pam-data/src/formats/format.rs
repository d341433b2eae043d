//! The trait of file formats.

use super::columns;
use crate::error::DataError;
use crate::load_options::LoadOptions;
use crate::models::saved_model::SavedModel;
use crate::recording::Recording;
use crate::rig_file::RigFile;
use std::borrow::Cow;
use std::fmt::Debug;
use std::path::Path;

/// The first bytes of a file and its name, from which a format is recognised.
#[derive(Debug)]
pub struct Head<'a> {
    /// Path of the file.
    pub path: &'a Path,
    /// Up to 64 KiB from the start of the file; never empty.
    pub bytes: &'a [u8],
    /// The same bytes as text.
    text: Cow<'a, str>,
}

impl<'a> Head<'a> {
    /// The head of a file with these first bytes.
    pub(super) fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self { path, bytes, text: String::from_utf8_lossy(bytes) }
    }

    /// True if the file has this extension.
    #[must_use]
    pub fn has_extension(&self, extension: &str) -> bool {
        self.path.extension().is_some_and(|e| e == extension)
    }

    /// Lines of text, without a byte-order mark.
    pub fn lines(&self) -> impl Iterator<Item = &str> {
        self.text.trim_start_matches('\u{feff}').lines()
    }

    /// The first line that is neither empty nor a comment (`#`).
    #[must_use]
    pub fn first_row(&self) -> &str {
        self.lines().find(|l| !l.starts_with('#') && !l.trim().is_empty()).unwrap_or("")
    }

    /// True if one of the standard columns is named between commas in the first row.
    #[must_use]
    pub fn names_standard_columns(&self) -> bool {
        self.first_row().split(',').any(|cell| columns::NAMES.contains(&cell.trim()))
    }
}

/// Writes a recording to a file.
pub type RecordingWriter = fn(&Path, &Recording) -> Result<(), DataError>;

/// A file format of recordings or models. A format implements what it can hold; the rest has defaults.
///
/// To add one, write its file in this folder, name the module in `mod.rs`, and add its type to [the list](super::list).
pub trait FileFormat: Debug + Send + Sync {
    /// Id, unique among formats.
    fn id(&self) -> &'static str;

    /// Name with its article, as in "this is a raw log".
    fn name(&self) -> &'static str;

    /// True if a file that begins like this is of the format. Formats are asked in the order of [`ALL`](super::list::ALL).
    fn recognises(&self, head: &Head<'_>) -> bool;

    /// True if this file of the format holds a recording.
    fn holds_recording(&self, path: &Path) -> bool {
        let _ = path;
        !self.holds_model()
    }

    /// True if files of the format hold models.
    fn holds_model(&self) -> bool {
        false
    }

    /// Reads the recordings of a file.
    ///
    /// # Errors
    /// [`DataError`] naming file, line and column; or that the format holds no recordings.
    fn read_recordings(
        &self,
        path: &Path,
        options: &LoadOptions,
    ) -> Result<Vec<Recording>, DataError> {
        let _ = options;
        Err(DataError::file(path, format!("a recording was expected, this is {}", self.name())))
    }

    /// True if [`read_recordings`](Self::read_recordings) filters the channels itself, so that
    /// [`LoadOptions::preprocess`] must not filter them again.
    fn filters_channels(&self) -> bool {
        false
    }

    /// The function that writes a recording, if the format can hold one that was computed, with the extension of
    /// its files.
    fn recording_writer(&self) -> Option<(&'static str, RecordingWriter)> {
        None
    }

    /// The rig that a file names as the one its recordings were made on.
    ///
    /// # Errors
    /// [`DataError`] if the file cannot be read or names it wrongly.
    fn rig(&self, path: &Path) -> Result<Option<RigFile>, DataError> {
        let _ = path;
        Ok(None)
    }

    /// Reads the model of a file.
    ///
    /// # Errors
    /// [`DataError`] naming the file and the fault; or that the format holds no models.
    fn read_model(&self, path: &Path) -> Result<SavedModel, DataError> {
        Err(DataError::file(
            path,
            format!("a model was expected (.safetensors or .eqx), this is {}", self.name()),
        ))
    }
}
