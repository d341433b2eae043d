//! Measuring a study again.

use super::{ResultsError, Source, Study};
use pam_data::DataError;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

/// Runs the commands of a study from `root` and reads the numbers and tables that they write. Also returns the names of values and
/// tables that no command writes and that stay unchanged. Commit, date, machine and cores become those of this run.
///
/// # Errors
/// [`ResultsError::Command`] if a command fails, [`ResultsError::Missing`] if it did not write what the study reads.
pub fn measure(study: &Study, root: &Path) -> Result<(Study, Vec<String>), ResultsError> {
    // `pam` in a command is the program of this repository.
    let release = root.join("target/release");
    let release = release.canonicalize().unwrap_or(release);
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::iter::once(release).chain(std::env::split_paths(&path));
    let path = std::env::join_paths(folders).unwrap_or(path);
    for command in &study.commands {
        eprintln!("$ {command}");
        // The standard output belongs to the caller.
        let status = Command::new("bash")
            .args(["-euo", "pipefail", "-c", command])
            .current_dir(root)
            .env("PATH", &path)
            .stdin(Stdio::null())
            .status()
            .map_err(|e| DataError::io("bash", e))?;
        if !status.success() {
            let (command, status) = (command.clone(), status.to_string());
            return Err(ResultsError::Command { command, status });
        }
    }
    let mut measured = study.clone();
    let mut untouched = Vec::new();
    for (key, value) in &mut measured.values {
        match &value.from {
            Some(source) => value.value = Some(read(source, root)?),
            None if value.cell.is_none() => untouched.push(key.clone()),
            None => {}
        }
    }
    for (key, table) in &mut measured.tables {
        if let Some(file) = &table.from_csv {
            table.rows = rows(&root.join(file), table.columns.len())?;
        } else if !table.from.is_empty() {
            for (row, sources) in table.rows.iter_mut().zip(&table.from) {
                for (cell, source) in row.iter_mut().zip(sources) {
                    if let Some(source) = source {
                        let number = read(source, root)?;
                        *cell = match source.decimals {
                            Some(0) => Value::from(number as i64),
                            _ => Value::from(number),
                        };
                    }
                }
            }
        } else if table.live_csv.is_none() {
            untouched.push(key.clone());
        }
    }
    measured.commit = output(root, "git describe --always --dirty --abbrev=12");
    measured.date = output(root, "date -u +%F");
    measured.machine = output(root, "sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1");
    measured.cores = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
    Ok((measured, untouched))
}

fn output(root: &Path, command: &str) -> String {
    let output = Command::new("bash").args(["-c", command]).current_dir(root).output();
    let text = output.map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned());
    text.ok().filter(|text| !text.is_empty()).unwrap_or_else(|| "unknown".into())
}

fn read(source: &Source, root: &Path) -> Result<f64, ResultsError> {
    let path = root.join(&source.file);
    let text = std::fs::read_to_string(&path).map_err(|e| DataError::io(&path, e))?;
    let missing = |message: String| ResultsError::Missing { path: path.clone(), message };
    let number = if let Some(pointer) = &source.pointer {
        let json: Value =
            serde_json::from_str(&text).map_err(|e| DataError::file(&path, e.to_string()))?;
        let number = json.pointer(pointer).and_then(Value::as_f64);
        number.ok_or_else(|| missing(format!("there is no number at {pointer}")))?
    } else if let Some(column) = &source.column {
        in_csv(&text, &source.row, column)
            .ok_or_else(|| missing(format!("no row {:?} with a number in {column}", source.row)))?
    } else {
        let after = source.after.as_deref().unwrap_or_default();
        number_after(&text, after)
            .ok_or_else(|| missing(format!("there is no number after `{after}`")))?
    };
    let number = source.scale * number;
    let rounded = source.decimals.and_then(|digits| format!("{number:.digits$}").parse().ok());
    Ok(rounded.unwrap_or(number))
}

/// The number of a column in the first row with these texts.
fn in_csv(text: &str, row: &BTreeMap<String, String>, column: &str) -> Option<f64> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let headers = reader.headers().ok()?.clone();
    let place = |name: &str| headers.iter().position(|h| h == name);
    let column = place(column)?;
    let wanted: Option<Vec<(usize, &str)>> =
        row.iter().map(|(name, value)| Some((place(name)?, value.as_str()))).collect();
    let wanted = wanted?;
    reader
        .records()
        .filter_map(Result::ok)
        .find(|record| wanted.iter().all(|&(k, value)| record.get(k) == Some(value)))
        .and_then(|record| record.get(column)?.parse().ok())
}

/// The number that follows a text.
fn number_after(text: &str, after: &str) -> Option<f64> {
    let rest = text.split_once(after)?.1.trim_start();
    let rest = rest.replace('−', "-");
    let is_part = |c: char| c.is_ascii_digit() || "+-.e".contains(c);
    let mut number = &rest[..rest.find(|c| !is_part(c)).unwrap_or(rest.len())];
    // A full stop at the end of a sentence is no part of it.
    while !number.is_empty() {
        if let Ok(value) = number.parse() {
            return Some(value);
        }
        number = &number[..number.len() - 1];
    }
    None
}

/// Rows of a CSV file with as many columns as a table.
pub(super) fn rows(path: &Path, columns: usize) -> Result<Vec<Vec<Value>>, ResultsError> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(path)
        .map_err(|e| DataError::file(path, e.to_string()))?;
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| DataError::file(path, e.to_string()))?;
        if record.len() != columns {
            let message = format!("{} columns where the study has {columns}", record.len());
            return Err(ResultsError::Missing { path: path.to_owned(), message });
        }
        rows.push(record.iter().map(cell).collect());
    }
    Ok(rows)
}

/// A cell: a whole number stays one, so that a page prints it as it is.
fn cell(text: &str) -> Value {
    if let Ok(whole) = text.parse::<i64>() {
        return whole.into();
    }
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Value::from(number),
        _ if text.is_empty() => Value::Null,
        _ => Value::from(text),
    }
}
