//! The file of one study.

use super::ResultsError;
use pam_data::DataError;
use pam_data::atomic::write_atomic;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Numbers and tables that were measured together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// One line on the measurement.
    pub title: String,
    /// Shell commands that measure it again, run in this order from the root of the repository.
    pub commands: Vec<String>,
    /// Commit whose program made the numbers.
    pub commit: String,
    /// Day of the measurement, `YYYY-MM-DD`.
    pub date: String,
    /// Processor and what else ran on it.
    pub machine: String,
    /// Cores that the programs could use.
    pub cores: u32,
    /// Conditions of the measurement: repeats, several commits, a machine under load.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
    /// Single numbers.
    #[serde(default)]
    pub values: BTreeMap<String, Measured>,
    /// Tables.
    #[serde(default)]
    pub tables: BTreeMap<String, Table>,
}

/// A number, or a reference to a cell of a table in which it stands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// The number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The cell that holds it, in place of `value`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<CellReference>,
    /// Unit; empty for ratios and counts.
    #[serde(default)]
    pub unit: String,
    /// Lower end of its 95 % interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Upper end of its 95 % interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// Standard deviation over repeats, seeds or recordings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread: Option<f64>,
    /// Description.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub about: String,
    /// Where a command of the study writes it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<Source>,
}

/// A cell of a table of the same study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellReference {
    /// Name of the table.
    pub table: String,
    /// First cells of the row.
    pub row: Vec<Value>,
    /// Name of the column.
    pub column: String,
}

/// A number in a file that a command writes: JSON by `pointer`, CSV by `row` and `column`, any text by `after`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// The file, from the root of the repository.
    pub file: String,
    /// Its place in a JSON file, as a JSON pointer (RFC 6901).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pointer: Option<String>,
    /// Columns of a CSV file with the text that they have in its row.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub row: BTreeMap<String, String>,
    /// Its column in a CSV file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// The text that stands before it; the first such place counts, and blanks between the two do not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
    /// Decimals to which it is rounded, in the unit of the value: a column may hold numbers of several sizes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decimals: Option<usize>,
    /// Factor from the file's unit to that of the value.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub scale: f64,
}

fn one() -> f64 {
    1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_one(scale: &f64) -> bool {
    (*scale - 1.0).abs() < f64::EPSILON
}

/// A table as it stands in a page.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Names of the columns, in Markdown.
    pub columns: Vec<String>,
    /// Decimals of the numbers of a column; `null` prints as many as the number has.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub decimals: Vec<Option<usize>>,
    /// Rows of numbers, Markdown texts and `null`.
    pub rows: Vec<Vec<Value>>,
    /// Where commands write the cells: as many rows and columns as the table, `null` for cells that stay.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub from: Vec<Vec<Option<Source>>>,
    /// CSV file that a command writes, with these columns in this order and `#` before comments.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_csv: Option<String>,
    /// CSV file of this repository, from the root, whose rows replace `rows` whenever it exists: another program writes it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub live_csv: Option<String>,
    /// Rows of `live_csv` with a cell that begins like this are left out: details that a page does not show.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub live_without: Option<String>,
}

impl Study {
    /// Reads the study at `path`, a file of `ROOT/results/`.
    pub(super) fn read(path: &Path) -> Result<Self, ResultsError> {
        let text = std::fs::read_to_string(path).map_err(|e| DataError::io(path, e))?;
        let mut study: Self =
            serde_json::from_str(&text).map_err(|e| DataError::file(path, e.to_string()))?;
        let root = path.parent().and_then(Path::parent).unwrap_or(Path::new(""));
        for table in study.tables.values_mut() {
            if let Some(csv) =
                table.live_csv.as_ref().map(|csv| root.join(csv)).filter(|csv| csv.exists())
            {
                table.rows = super::measure::rows(&csv, table.columns.len())?;
                if let Some(start) = &table.live_without {
                    let is_detail =
                        |cell: &Value| cell.as_str().is_some_and(|t| t.starts_with(start));
                    table.rows.retain(|row| !row.iter().any(is_detail));
                }
            }
        }
        Ok(study)
    }

    /// Writes the study, a row of a table per line.
    ///
    /// # Errors
    /// [`ResultsError::File`] if the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), ResultsError> {
        let value = serde_json::to_value(self).map_err(|e| DataError::file(path, e.to_string()))?;
        let mut text = String::new();
        pretty(&value, 0, &mut text);
        text.push('\n');
        Ok(write_atomic(path, text.as_bytes())?)
    }

    pub(super) fn value_of(&self, measured: &Measured) -> Option<f64> {
        let Some(cell) = &measured.cell else { return measured.value };
        let table = self.tables.get(&cell.table)?;
        let column = table.columns.iter().position(|c| *c == cell.column)?;
        let mut rows = table.rows.iter().filter(|row| row.starts_with(&cell.row));
        match (rows.next(), rows.next()) {
            (Some(row), None) => row.get(column)?.as_f64(),
            _ => None,
        }
    }
}

/// JSON whose arrays stand on one line unless they hold arrays or objects.
fn pretty(value: &Value, depth: usize, out: &mut String) {
    let nested = |v: &Value| matches!(v, Value::Array(_) | Value::Object(_));
    let indent = |n: usize| "  ".repeat(n);
    match value {
        Value::Object(map) if map.values().any(nested) || depth < 2 => {
            out.push('{');
            for (k, (key, item)) in map.iter().enumerate() {
                let comma = if k == 0 { "" } else { "," };
                let _ =
                    write!(out, "{comma}\n{}{}: ", indent(depth + 1), Value::from(key.as_str()));
                pretty(item, depth + 1, out);
            }
            let _ = write!(out, "\n{}}}", indent(depth));
        }
        Value::Array(items) if items.iter().any(nested) => {
            out.push('[');
            for (k, item) in items.iter().enumerate() {
                let comma = if k == 0 { "" } else { "," };
                let _ = write!(out, "{comma}\n{}", indent(depth + 1));
                pretty(item, depth + 1, out);
            }
            let _ = write!(out, "\n{}]", indent(depth));
        }
        flat => out.push_str(&flat.to_string()),
    }
}
