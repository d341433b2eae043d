//! Experiments from files of numbers.

use super::experiment::{Experiment, MeasuredInput};
use super::problem::FieldError;
use std::path::Path;

/// Name of the column with the times, s.
const TIME: &str = "time_s";

impl Experiment<MeasuredInput> {
    /// A run from a CSV file: a line of names, one of them `time_s`, then lines of numbers. Takes the columns of the inputs
    /// and the measured outputs by name; the experiment is called as the file. See [`sampled`](Self::sampled).
    ///
    /// # Errors
    /// [`FieldError::File`] if the file cannot be read, has no such column, or a line is not of numbers; it names line and
    /// column.
    pub fn read_csv(
        path: impl AsRef<Path>,
        inputs: &[&str],
        outputs: &[&str],
    ) -> Result<Self, FieldError> {
        let path = path.as_ref();
        let failed = |why: String| FieldError::File { path: path.to_owned(), why };
        let text = read_text(path).map_err(failed)?;
        let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let (_, header) = lines.next().ok_or_else(|| failed("the file is empty".into()))?;
        let header: Vec<&str> = header.split(',').map(str::trim).collect();
        let wanted: Vec<&str> = [TIME].iter().chain(inputs).chain(outputs).copied().collect();
        let places: Vec<usize> = wanted
            .iter()
            .map(|name| {
                let place = header.iter().position(|h| h == name);
                place.ok_or_else(|| failed(format!("there is no column `{name}` in {header:?}")))
            })
            .collect::<Result<_, _>>()?;
        let mut columns = vec![Vec::new(); wanted.len()];
        for (line, numbers) in lines {
            let cells: Vec<&str> = numbers.split(',').map(str::trim).collect();
            for ((column, &place), name) in columns.iter_mut().zip(&places).zip(&wanted) {
                let cell = cells.get(place).copied().unwrap_or_default();
                let number: f64 = cell.parse().map_err(|_| {
                    failed(format!("line {}, column `{name}`: `{cell}` is no number", line + 1))
                })?;
                column.push(number);
            }
        }
        let (times_s, rest) = columns.split_at(1);
        let (of_inputs, of_outputs) = rest.split_at(inputs.len());
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        Self::sampled(&name, &times_s[0], &zipped(inputs, of_inputs), &zipped(outputs, of_outputs))
            .map_err(|error| failed(error.to_string()))
    }
}

fn zipped<'c>(names: &[&'c str], columns: &'c [Vec<f64>]) -> Vec<(&'c str, &'c [f64])> {
    names.iter().copied().zip(columns.iter().map(Vec::as_slice)).collect()
}

/// A text file, of at most the size that commands read.
#[cfg(feature = "joint")]
fn read_text(path: &Path) -> Result<String, String> {
    pam_data::read_limit::read_text(path).map_err(|error| error.to_string())
}

/// A text file. The limit of what is read is part of `pam-data`, which fields alone do without.
#[cfg(not(feature = "joint"))]
fn read_text(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|error| error.to_string())
}
