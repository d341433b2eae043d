//! The configuration of a comparison.

use crate::error::BaselineError;
use crate::registry::AnyMethod;
use pam_data::{DataError, document, toml_file};
use pam_train::curriculum::{Selection, SelectionSet};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Recordings and how they are split: the same split for every model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataConfig {
    /// Files or folders, relative to the configuration file.
    pub recordings: Vec<PathBuf>,
    /// Recordings to fit to; the 29 published conditions by default.
    #[serde(default = "train")]
    pub train: Selection,
    /// Recordings to score on, never fitted to; the rest by default.
    #[serde(default = "rest")]
    pub held_out: Selection,
    /// Measured surfaces of a single muscle (`poly44_all_fits.mat`), for models of single muscles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surfaces: Option<PathBuf>,
}

fn train() -> Selection {
    Selection::Set(SelectionSet::Train)
}

fn rest() -> Selection {
    Selection::Set(SelectionSet::Rest)
}

/// How models are scored.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EvaluationConfig {
    /// Samples at the start of each recording that a warm-started prediction knows. Cold-started ones know
    /// the first sample only; both are scored on the samples after these.
    pub warm_up: usize,
    /// Recordings whose trajectories are drawn; the first held-out one if empty.
    pub figures: Vec<String>,
}

impl Default for EvaluationConfig {
    fn default() -> Self {
        Self { warm_up: 100, figures: Vec::new() }
    }
}

/// One model of the comparison.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModelConfig {
    /// Name in tables, unlike all others.
    pub name: String,
    /// How it is made.
    #[serde(flatten)]
    pub method: AnyMethod,
}

/// A comparison.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparisonConfig {
    /// Its name.
    pub name: String,
    /// Recordings.
    pub data: DataConfig,
    /// How models are scored.
    pub evaluation: EvaluationConfig,
    /// The models.
    #[serde(rename = "model")]
    pub models: Vec<ModelConfig>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    #[serde(default)]
    name: Option<String>,
    data: DataConfig,
    #[serde(default)]
    evaluation: EvaluationConfig,
    model: Vec<toml::Spanned<toml::Table>>,
}

impl ComparisonConfig {
    /// A configuration with every kind of model and its default settings, as TOML text.
    #[must_use]
    pub fn example() -> String {
        let mut text = String::from(
            "# Recordings, relative to this file, and how they are split: the same for all models.\n[data]\n\
             recordings = [\"logs\"]\n# train = \"train\"         # the 29 published conditions; \"all\", or names\n\
             # held_out = \"rest\"\n# surfaces = \"poly44_all_fits.mat\"  # single-muscle data of kind = \"kang\"\n\n\
             # [evaluation]\n# warm_up = 100           # samples that warm starts know\n\
             # figures = [\"nn_3065\"]  # recordings to draw\n",
        );
        for method in AnyMethod::defaults() {
            let settings = document::to_toml(&method).unwrap_or_default();
            text.push_str("\n[[model]]\n");
            text.push_str(&settings);
        }
        text
    }

    /// Reads a configuration file; paths in it are relative to it.
    ///
    /// # Errors
    /// [`BaselineError`] with the line.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, BaselineError> {
        Self::open_at(path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn open_at(path: &Path) -> Result<Self, BaselineError> {
        Self::parse(&toml_file::text(path)?, path)
    }

    /// Reads a configuration from text; `path` is for messages and relative paths.
    ///
    /// # Errors
    /// [`BaselineError`] with the line.
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Self, BaselineError> {
        Self::parse_at(text, path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn parse_at(text: &str, path: &Path) -> Result<Self, BaselineError> {
        let place = |offset: usize, message: String| -> BaselineError {
            DataError::line(path, document::line_of(text, offset), message).into()
        };
        let raw: Raw = toml_file::parse(text, path)?;
        let mut models: Vec<ModelConfig> = Vec::new();
        for spanned in raw.model {
            let start = spanned.span().start;
            let mut table = spanned.into_inner();
            let name = match table.remove("name") {
                None => None,
                Some(toml::Value::String(name)) => Some(name),
                Some(other) => {
                    return Err(place(start, format!("`name` must be a text, not {other}")));
                }
            };
            let method: AnyMethod =
                toml_file::from_table(&table).map_err(|why| place(start, why))?;
            method
                .method()
                .check()
                .map_err(|why| place(start, format!("{}: {why}", method.kind())))?;
            let name = name.unwrap_or_else(|| method.method().title());
            if models.iter().any(|m| m.name == name) {
                return Err(place(
                    start,
                    format!("two models are called `{name}`; give one a `name` of its own"),
                ));
            }
            models.push(ModelConfig { name, method });
        }
        if models.is_empty() {
            return Err(place(0, "there is no [[model]]".into()));
        }
        let mut data = raw.data;
        let folder = path.parent().unwrap_or(Path::new(""));
        for p in data.recordings.iter_mut().chain(&mut data.surfaces) {
            *p = folder.join(&*p);
        }
        let name = raw.name.unwrap_or_else(|| {
            path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
        });
        Ok(Self { name, data, evaluation: raw.evaluation, models })
    }
}
