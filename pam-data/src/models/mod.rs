//! Model files: the framework's own (safetensors) and the published weights (`.eqx`).

pub mod eqx;
pub mod safetensors_file;
pub mod saved_model;

pub use saved_model::{ModelInfo, SavedModel};

use crate::error::DataError;
use crate::formats::list::format_of;
use std::path::Path;

/// Loads a model from a file of either format.
///
/// # Errors
/// [`DataError`] if the file is of another kind, damaged, or holds a model whose inputs do not match.
///
/// ```
/// let saved = pam_data::load_model("../data/published/hybrid_model_puresine_16.eqx")?;
/// assert!((saved.model.physical().mass_kg - 304.648).abs() < 1e-3);
/// # Ok::<(), pam_data::DataError>(())
/// ```
pub fn load_model(path: impl AsRef<Path>) -> Result<SavedModel, DataError> {
    load_model_at(path.as_ref())
}

/// One instance, whatever the path is given as.
fn load_model_at(path: &Path) -> Result<SavedModel, DataError> {
    format_of(path)?.read_model(path)
}

/// Reads a model of the framework's format from memory; `path` is for messages.
///
/// # Errors
/// As [`load_model`].
pub fn parse_model(path: impl AsRef<Path>, bytes: &[u8]) -> Result<SavedModel, DataError> {
    parse_model_at(path.as_ref(), bytes)
}

/// One instance, whatever the path is given as.
fn parse_model_at(path: &Path, bytes: &[u8]) -> Result<SavedModel, DataError> {
    safetensors_file::parse(path, bytes)
}

/// Writes a model in the format of the extension: `.safetensors` or `.eqx`.
///
/// # Errors
/// [`DataError`] if the extension is another one, or the format cannot hold the model.
pub fn save_model(path: impl AsRef<Path>, saved: &SavedModel) -> Result<(), DataError> {
    save_model_at(path.as_ref(), saved)
}

/// One instance, whatever the path is given as.
fn save_model_at(path: &Path, saved: &SavedModel) -> Result<(), DataError> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("safetensors") => safetensors_file::write(path, saved),
        Some("eqx") => eqx::write(path, saved),
        _ => Err(DataError::file(path, "model files end in .safetensors or .eqx")),
    }
}
