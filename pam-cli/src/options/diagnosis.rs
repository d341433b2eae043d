//! Candidates and settings of a diagnosis that a command foretells or repeats.

use crate::arguments::GlobalOptions;
use crate::error::{CliError, failed, usage};
use clap::Args;
use pam_data::toml_file;
use pam_diagnose::{DiagnoseOptions, DiagnosisSettings};
use pam_effects::EffectRecord;
use pam_effects::effects::{AnyEffect, by_id};
use pam_experiment::certify::Certificate;
use pam_experiment::detect::GivenValues;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Settings of a diagnosis.
#[derive(Debug, Clone, Args)]
pub struct DiagnosisOptions {
    /// Settings of the diagnosis (see docs/diagnosis.md)
    #[arg(long, value_name = "FILE.toml")]
    pub settings: Option<PathBuf>,
    /// Change one setting, like `search.max_causes=4`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
}

impl DiagnosisOptions {
    /// Options of a diagnosis with all candidates.
    ///
    /// # Errors
    /// [`CliError`] naming the file or the option.
    pub fn diagnosis(&self, global: &GlobalOptions) -> Result<DiagnoseOptions, CliError> {
        let (settings, _) = settings_of(self.settings.as_deref(), &self.overrides)?;
        Ok(DiagnoseOptions {
            seed: global.seed,
            settings,
            allow_implausible: global.accept,
            law: false,
            ..DiagnoseOptions::default()
        })
    }

    /// As JSON, for run folders.
    #[must_use]
    pub fn to_json(options: &DiagnoseOptions) -> Value {
        json!({
            "candidates": options.candidates.iter().map(|e| e.info().id).collect::<Vec<_>>(),
            "settings": options.settings,
        })
    }
}

/// Settings from a file with single changes, and the certificate that the file carries.
///
/// # Errors
/// [`CliError`] naming the file or the change.
pub fn settings_of(
    path: Option<&Path>,
    changes: &[String],
) -> Result<(DiagnosisSettings, Option<Certificate>), CliError> {
    let Some(path) = path else {
        return Ok((DiagnosisSettings::parse("", changes).map_err(usage)?, None));
    };
    let fail = |e: &dyn std::fmt::Display| failed(format!("{}: {e}", path.display()));
    let (text, certificate) = Certificate::split(&toml_file::text(path)?).map_err(|e| fail(&e))?;
    DiagnosisSettings::parse(&text, &[]).map_err(|e| fail(&e))?;
    Ok((DiagnosisSettings::parse(&text, changes).map_err(usage)?, certificate))
}

/// The effect of an id on the command line.
///
/// # Errors
/// [`CliError::Usage`] that lists the ids.
pub fn effect(id: &str) -> Result<&'static dyn AnyEffect, CliError> {
    by_id(id.trim())
        .ok_or_else(|| usage(format!("--effects: {}", EffectRecord::unknown(id.trim(), &[]))))
}

/// Effects on the command line with values that are kept, like `creep:time_constant_s=2`.
///
/// # Errors
/// [`CliError::Usage`] naming the text that cannot be read, or listing the ids.
pub fn given_values(texts: &[String]) -> Result<Vec<GivenValues>, CliError> {
    let one = |text: &String| {
        let given: GivenValues =
            text.parse().map_err(|e| usage(format!("--effects {text}: {e}")))?;
        effect(&given.effect)?;
        Ok(given)
    };
    texts.iter().map(one).collect()
}
