//! The files of the study.

use super::findings::findings;
use super::report::report;
use super::result::{Row, StudyResult};
use super::table::tables;
use pam_data::DataError;
use pam_data::atomic::write_atomic;
use std::path::Path;

/// The result as JSON text.
///
/// # Panics
/// Never: rows are plain numbers and texts.
#[must_use]
pub fn to_json(result: &StudyResult) -> String {
    serde_json::to_string_pretty(result).expect("rows are plain numbers and texts") + "\n"
}

/// The rows as CSV text.
///
/// # Panics
/// Never: rows are plain numbers and texts, and writing into memory cannot fail.
#[must_use]
pub fn to_csv(rows: &[Row]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).expect("rows are flat");
    }
    let bytes = writer.into_inner().expect("writing into memory cannot fail");
    String::from_utf8(bytes).expect("rows are text")
}

/// The findings and the tables as markdown text.
#[must_use]
pub fn to_markdown(result: &StudyResult) -> String {
    let mut text = format!("{}\n", about(result));
    for finding in findings(result) {
        text += &format!("\n- {finding}");
    }
    text += "\n";
    for table in tables(result) {
        text += "\n";
        text += &table.to_markdown();
    }
    text
}

/// The run in one sentence.
#[must_use]
pub fn about(result: &StudyResult) -> String {
    let failed = result.rows.iter().filter(|row| row.failure.is_some()).count();
    let processor = result.processor.as_deref().unwrap_or("an unknown processor");
    let form = if result.quick { "short" } else { "full" };
    format!(
        "{} gradients, of which {failed} failed ({form} form); median times of up to {} runs on one \
         thread of {processor}.",
        result.rows.len(),
        result.repeat
    )
}

/// Writes `gradients.json`, `gradients.csv`, `table.md` and `report.html` to `folder`; `made_by` names
/// program and version.
///
/// # Errors
/// [`DataError::Io`] naming the file that cannot be written.
pub fn write(
    folder: impl AsRef<Path>,
    result: &StudyResult,
    made_by: &str,
) -> Result<(), DataError> {
    let folder = folder.as_ref();
    write_atomic(folder.join("gradients.json"), to_json(result).as_bytes())?;
    write_atomic(folder.join("gradients.csv"), to_csv(&result.rows).as_bytes())?;
    write_atomic(folder.join("table.md"), to_markdown(result).as_bytes())?;
    write_atomic(folder.join("report.html"), report(result, made_by).as_bytes())
}
