//! `.npz` files of the standard columns, with the masses as scalars.

use super::columns::{self, MASS_EXTENSOR, MASS_FLEXOR, NAMES, NEEDED, VELOCITY};
use super::format::{FileFormat, Head, RecordingWriter};
use super::npz::{self, Array};
use crate::error::DataError;
use crate::load_options::{LoadOptions, PressureReference};
use crate::recording::Recording;
use std::collections::BTreeMap;
use std::path::Path;

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
        read_from(path, options.pressure_reference)
    }
    fn recording_writer(&self) -> Option<(&'static str, RecordingWriter)> {
        Some(("npz", write))
    }
}

/// Reads an `.npz` file whose arrays are the standard columns; gaps in time split it.
///
/// # Errors
/// [`DataError`] naming a missing array, arrays of different lengths, numbers that are not finite,
/// times that do not increase, or masses that are not positive.
pub fn read(path: &Path) -> Result<Vec<Recording>, DataError> {
    read_from(path, PressureReference::Absolute)
}

/// [`read`] for pressures that count from `reference`.
///
/// # Errors
/// As [`read`].
pub fn read_from(path: &Path, reference: PressureReference) -> Result<Vec<Recording>, DataError> {
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
    let mass = |name: &str| {
        let Some(array) = arrays.get(name) else { return Ok(None) };
        match array.values[..] {
            [m] if m.is_finite() && m > 0.0 => Ok(Some(m)),
            _ => Err(DataError::file(
                path,
                format!("`{name}` must be one positive number, got {:?}", array.values),
            )),
        }
    };
    let masses = [mass(MASS_FLEXOR)?, mass(MASS_EXTENSOR)?];
    columns::finish(Recording::empty(path), values, velocity, masses, reference)
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
    if let Some(m) = recording.given_masses {
        arrays.insert(MASS_FLEXOR.into(), Array::scalar(m.flexor_g));
        arrays.insert(MASS_EXTENSOR.into(), Array::scalar(m.extensor_g));
    }
    npz::write(path, &arrays)
}
