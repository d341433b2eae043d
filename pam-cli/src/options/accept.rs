//! Findings for which a command refuses recordings unless `--accept` is given.

use crate::arguments::GlobalOptions;
use crate::console::Console;
use crate::error::CliError;
use pam_core::parallel;
use pam_data::plausibility::{PlausibilitySettings, Severity};
use pam_data::quality::{QualityKind, QualitySettings};
use pam_data::{SavedModel, Subject, plausibility, quality};

/// Prints what in recordings contradicts the physics of the joint.
///
/// # Errors
/// [`CliError::Failed`] if that is certain and `--accept` is not given.
pub fn check_plausible(
    saved: &SavedModel,
    subjects: &[Subject],
    global: &GlobalOptions,
    console: &Console,
) -> Result<(), CliError> {
    let settings = PlausibilitySettings::for_model(saved);
    let findings = plausibility::check_with(&saved.model, subjects, &settings);
    let errors = plausibility::errors(&findings);
    if !(errors.is_empty() || global.accept) {
        let sentences: Vec<String> = errors.iter().map(ToString::to_string).collect();
        return Err(CliError::Failed(format!(
            "{}. Look at the data with `pam inspect`, describe them with --rig-file, or use them all the same with \
             --accept",
            sentences.join("; ")
        )));
    }
    findings.iter().for_each(|finding| console.warn(finding.to_string()));
    check_quality(subjects, global, console)
}

/// Prints what makes recordings worth less than they look: clipped, dead and delayed channels.
///
/// # Errors
/// [`CliError::Failed`] if a channel is clipped or dead and `--accept` is not given.
pub fn check_quality(
    subjects: &[Subject],
    global: &GlobalOptions,
    console: &Console,
) -> Result<(), CliError> {
    let mut errors = Vec::new();
    let assess = |i: usize| quality::assess(&subjects[i].recording, &QualitySettings::default());
    for quality in parallel::map(subjects.len(), assess) {
        for finding in quality.findings {
            let sentence = format!("{}: {}", quality.recording, finding.message);
            match (finding.severity, finding.kind) {
                (Severity::Error, _) if !global.accept => errors.push(sentence),
                (Severity::Error, _) | (_, QualityKind::Delay | QualityKind::Dead) => {
                    console.warn(sentence);
                }
                // The rest is for `pam inspect`: it limits what can be learned, and nothing is wrong.
                _ => {}
            }
        }
    }
    if errors.is_empty() {
        return Ok(());
    }
    Err(CliError::Failed(format!(
        "{}. Look at the data with `pam inspect --out DIR`, or use them all the same with --accept",
        errors.join("; ")
    )))
}
