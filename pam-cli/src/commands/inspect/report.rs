//! `report.html`: the checks of all recordings as pictures.

use crate::error::CliError;
use pam_data::DataError;
use pam_data::atomic::write_atomic;
use pam_data::plausibility::{Finding, Severity};
use pam_report::page::count;
use pam_report::{InspectedRun, inspection_report};
use std::path::{Path, PathBuf};

/// Writes `report.html` into a folder and returns its path.
pub(super) fn write_report(
    folder: &Path,
    runs: &[InspectedRun],
    findings: &[Finding],
) -> Result<PathBuf, CliError> {
    let (errors, warnings) = runs
        .iter()
        .flat_map(|run| run.quality.findings.iter().map(|f| f.severity))
        .chain(findings.iter().map(|f| f.severity))
        .fold((0, 0), |(e, w), severity| match severity {
            Severity::Error => (e + 1, w),
            Severity::Warning => (e, w + 1),
        });
    let lead = format!(
        "{}: {} that would stop other commands, {}.",
        count(runs.len(), "recording"),
        count(errors, "error"),
        count(warnings, "warning")
    );
    let made_by = format!("pam {} inspect", env!("CARGO_PKG_VERSION"));
    let html = inspection_report("Check of recordings", &lead, runs, findings, &made_by);
    std::fs::create_dir_all(folder).map_err(|e| DataError::io(folder, e))?;
    let path = folder.join("report.html");
    write_atomic(&path, html.as_bytes())?;
    Ok(path)
}
