//! A folder of outcomes: one file for each case, complete or absent.

use super::{Case, Outcome};
use pam_data::atomic::write_atomic;
use std::path::{Path, PathBuf};

/// The file of a case.
#[must_use]
pub fn path(folder: &Path, case: &Case) -> PathBuf {
    folder.join(format!("{}.json", case.id))
}

/// The stored outcome of a case; `None` if there is none, or one of another case under its id.
#[must_use]
pub fn stored(folder: &Path, case: &Case) -> Option<Outcome> {
    let text = std::fs::read_to_string(path(folder, case)).ok()?;
    let outcome: Outcome = serde_json::from_str(&text).ok()?;
    (outcome.case == *case).then_some(outcome)
}

/// Stores an outcome.
///
/// # Errors
/// A sentence with the path.
pub fn store(folder: &Path, outcome: &Outcome) -> Result<(), String> {
    let text = serde_json::to_string(outcome).map_err(|e| e.to_string())?;
    let path = path(folder, &outcome.case);
    write_atomic(&path, format!("{text}\n").as_bytes()).map_err(|e| e.to_string())
}

/// All outcomes of a folder in the order of their ids.
///
/// # Errors
/// A sentence with the file that cannot be read.
pub fn all(folder: &Path) -> Result<Vec<Outcome>, String> {
    let told = |e: std::io::Error| format!("{}: {e}", folder.display());
    let entries = std::fs::read_dir(folder).map_err(told)?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "json"));
    paths.sort();
    paths
        .iter()
        .map(|path| {
            let text = std::fs::read_to_string(path).map_err(told)?;
            serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))
        })
        .collect()
}
