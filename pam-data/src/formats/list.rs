//! The list of file formats.

use super::format::{FileFormat, Head, RecordingWriter};
use crate::error::DataError;
use crate::read_limit;
use crate::recording::Recording;
use crate::table::container;
use std::io::Read;
use std::path::Path;

macro_rules! formats {
    ($($format:path),+ $(,)?) => {
        /// All formats, in the order in which they are asked whether they recognise a file.
        pub static ALL: &[&dyn FileFormat] = &[$(&$format),+];
    };
}

formats! {
    super::mat_run::MatRun,
    crate::models::eqx::Eqx,
    super::npz_columns::NpzColumns,
    crate::models::safetensors_file::Safetensors,
    super::csv_columns::CsvColumns,
    super::raw_log::RawLogText,
}

/// The format of a file, judged by its first bytes and its extension.
///
/// # Errors
/// [`DataError`] if the file cannot be read, is empty, or is of no known format.
pub fn format_of(path: &Path) -> Result<&'static dyn FileFormat, DataError> {
    let mut bytes = Vec::new();
    read_limit::open(path)?
        .take(65536)
        .read_to_end(&mut bytes)
        .map_err(|e| DataError::io(path, e))?;
    if bytes.is_empty() {
        return Err(DataError::file(path, "the file is empty"));
    }
    if let Some(why) = container::missing_feature(&bytes) {
        return Err(DataError::file(path, why));
    }
    if container::needs_rig_file(&bytes) {
        let message = format!(
            "a table without standard columns: describe it in a rig file and give it with --rig-file; `pam rig-file init \
             {}` writes a first one",
            path.display()
        );
        return Err(DataError::file(path, message));
    }
    let head = Head::new(path, &bytes);
    ALL.iter().find(|format| format.recognises(&head)).copied().ok_or_else(|| {
        let names: Vec<&str> = ALL.iter().map(|format| format.name()).collect();
        DataError::file(
            path,
            format!("not a file this program knows; it reads {}", names.join(", ")),
        )
    })
}

/// The function that writes recordings to files with the extension of this path.
///
/// # Errors
/// [`DataError`] if no format with this extension can hold a recording.
pub fn writer_for(path: &Path) -> Result<RecordingWriter, DataError> {
    let writers: Vec<_> = ALL.iter().filter_map(|format| format.recording_writer()).collect();
    let fits = |(extension, _): &&(&str, _)| path.extension().is_some_and(|e| e == *extension);
    writers.iter().find(fits).map(|(_, write)| *write).ok_or_else(|| {
        let known: Vec<String> = writers.iter().map(|(e, _)| format!(".{e}")).collect();
        DataError::file(path, format!("a recording is written as {}", known.join(" or ")))
    })
}

/// Writes a recording in the format of the path's extension.
///
/// # Errors
/// [`DataError`] if no format with this extension can hold a recording, or the file cannot be written.
pub fn write_recording(path: &Path, recording: &Recording) -> Result<(), DataError> {
    writer_for(path)?(path, recording)
}
