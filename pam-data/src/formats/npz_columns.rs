//! `.npz` files of the standard columns, with masses and reading at rest as scalars and the rig as the member `rig.toml`.

use super::columns::{self, Header, NAMES, NEEDED, VELOCITY};
use super::format::{FileFormat, Head, RecordingWriter};
use super::npz::{self, Array};
use crate::error::DataError;
use crate::load_options::LoadOptions;
use crate::recording::Recording;
use crate::rig_file::RigFile;
use std::collections::BTreeMap;
use std::path::Path;

/// Member of the archive with the rig; NumPy reads it as bytes.
const RIG_MEMBER: &str = "rig.toml";

/// The format of `.npz` archives of the standard columns.
#[derive(Debug)]
pub struct NpzColumns;

impl FileFormat for NpzColumns {
    fn id(&self) -> &'static str {
        "npz"
    }
    fn name(&self) -> &'static str {
        "an .npz archive"
    }
    fn recognises(&self, head: &Head<'_>) -> bool {
        head.bytes.starts_with(b"PK") || head.has_extension("npz")
    }
    fn holds_recording(&self, path: &Path) -> bool {
        npz::names(path).is_ok_and(|names| names.iter().any(|n| n == "time_s"))
    }
    fn read_recordings(
        &self,
        path: &Path,
        options: &LoadOptions,
    ) -> Result<Vec<Recording>, DataError> {
        read_with(path, options)
    }
    fn recording_writer(&self) -> Option<(&'static str, RecordingWriter)> {
        Some(("npz", write))
    }
    fn rig(&self, path: &Path) -> Result<Option<RigFile>, DataError> {
        rig_in(path)
    }
}

/// Reads an `.npz` file whose arrays are the standard columns; gaps in time split it.
///
/// # Errors
/// [`DataError`] naming a missing array, arrays of different lengths, numbers that are not finite,
/// times that do not increase, or masses that are not positive.
pub fn read(path: &Path) -> Result<Vec<Recording>, DataError> {
    read_with(path, &LoadOptions::default())
}

/// [`read`] with the zero of the pressures and the rig that the options give.
///
/// # Errors
/// As [`read`].
pub fn read_with(path: &Path, options: &LoadOptions) -> Result<Vec<Recording>, DataError> {
    let mut arrays = npz::read(path)?;
    let present = arrays.keys().cloned().collect::<Vec<_>>().join(", ");
    let missing: Vec<&str> =
        NEEDED.iter().filter(|name| !arrays.contains_key(**name)).copied().collect();
    if !missing.is_empty() {
        let (array, be) = if missing.len() == 1 { ("array", "is") } else { ("arrays", "are") };
        return Err(DataError::file(
            path,
            format!(
                "{array} `{}` {be} missing; the arrays here are [{present}], needed are {}. Describe files of other \
                 names and units in a rig file: `pam rig-file init {}` writes a first one",
                missing.join("`, `"),
                NAMES.join(", "),
                path.display()
            ),
        ));
    }
    let mut take = |name: &str| arrays.remove(name).map(|array| array.values);
    let velocity = take(VELOCITY);
    let values = NEEDED.map(|name| take(name).unwrap_or_default());
    let mut header = Header::default();
    for (place, name) in Header::KEYS.iter().enumerate() {
        let Some(array) = arrays.get(*name) else { continue };
        let [value] = array.values[..] else {
            let message = format!("`{name}` must be one number, got {:?}", array.values);
            return Err(DataError::file(path, message));
        };
        header.set(place, value).map_err(|e| DataError::file(path, format!("`{name}`: {e}")))?;
    }
    header.rig = rig_in(path)?;
    let recording = Recording::empty(path);
    columns::finish(recording, values, velocity, header, options)
}

/// The rig of an archive's member of that name.
fn rig_in(path: &Path) -> Result<Option<RigFile>, DataError> {
    let text = npz::read_member(path, RIG_MEMBER)?;
    text.map(|text| RigFile::parse(&text, path.join(RIG_MEMBER))).transpose()
}

/// Writes a recording as `.npz`.
///
/// # Errors
/// [`DataError::Io`].
pub fn write(path: &Path, recording: &Recording) -> Result<(), DataError> {
    let mut arrays: BTreeMap<String, Array> = NAMES
        .iter()
        .zip(columns::of(recording))
        .map(|(name, values)| ((*name).to_owned(), Array::vector(values)))
        .collect();
    for (key, value) in columns::numbers_of(recording, recording.given_masses) {
        arrays.insert(key.to_owned(), Array::scalar(value));
    }
    let rig = recording.rig.as_ref().map(|rig| rig.to_toml());
    npz::write_with(path, &arrays, rig.as_deref().map(|text| (RIG_MEMBER, text)))
}
