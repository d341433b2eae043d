//! Model files: the framework's own (safetensors) and the published weights (`.eqx`).

pub mod eqx;
pub mod safetensors_file;

use crate::error::DataError;
use crate::formats::list::format_of;
use pam_core::{AnyForce, JointModel};
use std::path::{Path, PathBuf};

/// Metadata of a model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ModelInfo {
    /// Name for reports.
    pub name: String,
    /// Where its numbers come from.
    pub provenance: String,
    /// True if it was fitted to data; decides how masses are found by default.
    pub trained: bool,
    /// Names of the recordings it was fitted to, if they are known.
    pub trained_on: Vec<String>,
    /// Effects that extend the joint model, in the order in which they act; empty for a model without. They are
    /// carried through unchanged: `pam-effects` reads and writes them.
    pub effects: Vec<serde_json::Value>,
    /// The file it was read from, if any.
    pub source: Option<PathBuf>,
}

/// A joint model as it stands in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedModel {
    /// The model.
    pub model: JointModel<f64, AnyForce<f64>>,
    /// Its metadata.
    pub info: ModelInfo,
}

/// Loads a model from a file of either format.
///
/// # Errors
/// [`DataError`] if the file is of another kind, damaged, or holds a model whose inputs do not match.
pub fn load_model(path: &Path) -> Result<SavedModel, DataError> {
    format_of(path)?.read_model(path)
}

/// Reads a model of the framework's format from memory; `path` is for messages.
///
/// # Errors
/// As [`load_model`].
pub fn parse_model(path: &Path, bytes: &[u8]) -> Result<SavedModel, DataError> {
    safetensors_file::parse(path, bytes)
}

/// Writes a model in the format of the extension: `.safetensors` or `.eqx`.
///
/// # Errors
/// [`DataError`] if the extension is another one, or the format cannot hold the model.
pub fn save_model(path: &Path, saved: &SavedModel) -> Result<(), DataError> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("safetensors") => safetensors_file::write(path, saved),
        Some("eqx") => eqx::write(path, saved),
        _ => Err(DataError::file(path, "model files end in .safetensors or .eqx")),
    }
}
