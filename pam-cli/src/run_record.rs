//! The record of a run: program, version, commit, seed and configuration.

use crate::error::CliError;
use pam_data::atomic::write_atomic;
use serde_json::{Value, json};
use std::path::Path;

/// Program, version and commit in one line.
#[must_use]
pub fn made_by() -> String {
    format!("pam {} ({})", env!("CARGO_PKG_VERSION"), env!("PAM_GIT_HASH"))
}

/// Writes `run.json`: program, version, commit, seed and configuration. Things that do not change
/// the results (threads, time of day) are left out, so that equal runs give equal bytes.
///
/// # Errors
/// [`CliError::Data`] if the file cannot be written.
pub fn write(
    folder: impl AsRef<Path>,
    command: &str,
    seed: u64,
    configuration: &Value,
) -> Result<(), CliError> {
    let folder = folder.as_ref();
    let record = json!({
        "program": "pam",
        "version": env!("CARGO_PKG_VERSION"),
        "git": env!("PAM_GIT_HASH"),
        "command": command,
        "seed": seed,
        "configuration": configuration,
    });
    write_json(folder.join("run.json"), &record)
}

/// Writes JSON to a file.
///
/// # Errors
/// [`CliError::Data`] if the file cannot be written.
pub fn write_json(path: impl AsRef<Path>, value: &Value) -> Result<(), CliError> {
    let path = path.as_ref();
    write_atomic(path, format!("{value:#}\n").as_bytes())?;
    Ok(())
}

/// First line of a log that the virtual rig makes.
#[must_use]
pub fn rig_note(seed: u64) -> String {
    format!("made by the virtual rig of pam {}, seed {seed}", env!("CARGO_PKG_VERSION"))
}
