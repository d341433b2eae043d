//! Measuring a study again.

use super::{ResultsError, Source, Study};
use pam_data::DataError;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Stdio};

/// Runs the commands of a study from `root` and reads the numbers and tables that they write. Also returns the names of values and
/// tables that no command writes and that stay unchanged. Commit, date, machine and cores become those of this run.
///
/// # Errors
/// [`ResultsError::Command`] if a command fails, [`ResultsError::Missing`] if it did not write what the study reads.
pub fn measure(study: &Study, root: &Path) -> Result<(Study, Vec<String>), ResultsError> {
    for command in &study.commands {
        eprintln!("$ {command}");
        // The standard output belongs to the caller.
        let status = Command::new("bash")
            .args(["-euo", "pipefail", "-c", command])
            .current_dir(root)
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
        match &table.from_csv {
            Some(file) => table.rows = rows(&root.join(file), table.columns.len())?,
            None if table.live_csv.is_some() => {}
            None => untouched.push(key.clone()),
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
    let json: Value =
        serde_json::from_str(&text).map_err(|e| DataError::file(&path, e.to_string()))?;
    let number = json.pointer(&source.pointer).and_then(Value::as_f64);
    let missing = || format!("there is no number at {}", source.pointer);
    Ok(source.scale * number.ok_or_else(|| ResultsError::Missing { path, message: missing() })?)
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

fn cell(text: &str) -> Value {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Value::from(number),
        _ if text.is_empty() => Value::Null,
        _ => Value::from(text),
    }
}
