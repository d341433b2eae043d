//! Models that are done, kept in a folder, so that an interrupted comparison goes on.
//!
//! A kept model is taken over only for the same program, data, settings and seed: all of them are in its
//! key.

use super::config::{ComparisonConfig, ModelConfig};
use super::result::FinishedModel;
use super::split::Split;
use crate::error::BaselineError;
use pam_data::atomic::write_atomic;
use pam_data::fingerprint::fingerprint_of_subjects;
use pam_data::formats::npz::{self, Array};
use pam_data::{DataError, MuscleSurfaces, document, read_limit};
use pam_numerics::ContentHash;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Folder that holds the models of a comparison that are done.
#[derive(Debug, Clone, Copy)]
pub struct ModelCache<'a> {
    /// The folder.
    pub folder: &'a Path,
    /// True if models that are there already are taken over.
    pub resume: bool,
    /// Program and version; what another one kept is not taken over.
    pub program: &'a str,
}

#[derive(Serialize, Deserialize)]
struct Entry {
    key: String,
    checksum: String,
    finished: FinishedModel,
}

impl ModelCache<'_> {
    /// A model that was done before with this key.
    pub(super) fn read(&self, stem: &str, key: &str) -> Option<FinishedModel> {
        if !self.resume {
            return None;
        }
        let text = read_limit::read_text(self.path(stem, "json")).ok()?;
        let kept: Entry = document::from_json(&text).ok()?;
        let sound = checksum(&kept.key, &kept.finished).is_ok_and(|sum| sum == kept.checksum);
        (kept.key == key && sound).then_some(kept.finished)
    }

    /// Keeps a model and its numbers.
    pub(super) fn write(
        &self,
        stem: &str,
        key: String,
        finished: &FinishedModel,
        arrays: &BTreeMap<String, Array>,
    ) -> Result<(), BaselineError> {
        npz::write(&self.path(stem, "npz"), arrays)?;
        let path = self.path(stem, "json");
        let fail = |e: document::DocumentError| {
            DataError::file(&path, format!("the result cannot be written: {e}"))
        };
        let checksum = checksum(&key, finished).map_err(fail)?;
        let kept = Entry { key, checksum, finished: finished.clone() };
        let text = document::to_json(&kept).map_err(fail)?;
        write_atomic(&path, text.as_bytes())?;
        Ok(())
    }

    fn path(&self, stem: &str, extension: &str) -> PathBuf {
        self.folder.join("models").join(format!("{stem}.{extension}"))
    }
}

/// The checksum by which a result that was edited or damaged.
fn checksum(key: &str, finished: &FinishedModel) -> Result<String, document::DocumentError> {
    let mut hash = ContentHash::default();
    hash.text(key);
    hash.text(&document::to_json(finished)?);
    Ok(hash.hex())
}

/// Names of the models' files without extension, one for each model: `A+` and `A-` become `a` and `a-2`.
pub(super) fn stems(models: &[ModelConfig]) -> Vec<String> {
    let mut stems: Vec<String> = Vec::new();
    for model in models {
        let base = match slug(&model.name) {
            empty if empty.is_empty() => "model".to_owned(),
            slug => slug,
        };
        let mut stem = base.clone();
        let mut number = 2;
        while stems.contains(&stem) {
            stem = format!("{base}-{number}");
            number += 1;
        }
        stems.push(stem);
    }
    stems
}

/// Everything that a model's result depends on, as a text, for each model of a comparison.
pub(super) fn key<'a>(
    config: &'a ComparisonConfig,
    sets: &Split,
    surfaces: Option<&MuscleSurfaces>,
    seed: u64,
    program: &'a str,
) -> impl Fn(&ModelConfig) -> String + use<'a> {
    let recordings = [&sets.train, &sets.held_out].map(fingerprint_of_subjects);
    // The text of all coefficients.
    let surfaces = surfaces.map(|s| {
        let mut hash = ContentHash::default();
        hash.text(&format!("{s:?}"));
        hash.hex()
    });
    move |model| {
        serde_json::json!({
            "program": program,
            "model": model,
            "files": model.method.method().content_of_files(),
            "evaluation": config.evaluation,
            "recordings": recordings,
            "surfaces": surfaces,
            "seed": seed,
        })
        .to_string()
    }
}

/// A name as part of a file name.
fn slug(name: &str) -> String {
    let mut slug = String::new();
    for c in name.chars() {
        if c.is_ascii_alphanumeric() {
            slug.push(c.to_ascii_lowercase());
        } else if !slug.ends_with('-') {
            slug.push('-');
        }
    }
    slug.trim_matches('-').to_owned()
}
