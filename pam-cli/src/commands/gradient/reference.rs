//! True displacements, against which predictions are held.

use super::Measured;
use crate::error::CliError;
use pam_data::formats::npz::{self, Array};
use pam_data::{DataError, Subject};
use std::path::Path;

/// The true displacements (mm) of each recording.
pub(super) fn reference_displacements(
    path: &Path,
    subjects: &[Subject],
) -> Result<Vec<Vec<f64>>, CliError> {
    let arrays = npz::read(path)?;
    let wrong =
        |why: String| CliError::from(DataError::File { path: path.to_path_buf(), message: why });
    let lengths: Vec<usize> = subjects.iter().map(|s| s.recording.len()).collect();
    if let Some(all) = arrays.get("x") {
        if let Some(names) = npz::read_texts(path, "names")? {
            return named_rows(all, &names, subjects).map_err(wrong);
        }
        // `[recordings, samples]` where all are of one length, else one after the other.
        let total: usize = lengths.iter().sum();
        if all.values.len() != total {
            return Err(wrong(format!(
                "`x` has shape {:?}; the recordings have {total} samples in all",
                all.shape
            )));
        }
        let mut rest = &all.values[..];
        return Ok(lengths
            .iter()
            .map(|&n| {
                let (own, next) = rest.split_at(n);
                rest = next;
                own.to_vec()
            })
            .collect());
    }
    subjects
        .iter()
        .enumerate()
        .map(|(i, s)| {
            let name = &s.recording.name;
            let keys = [format!("x_{i}"), format!("x_{name}"), name.clone()];
            let array = keys.iter().find_map(|k| arrays.get(k)).ok_or_else(|| {
                wrong(format!("there is neither `x` nor `{}` for recording {name}", keys[0]))
            })?;
            if array.values.len() == s.recording.len() {
                Ok(array.values.clone())
            } else {
                Err(wrong(format!(
                    "recording {name} has {} samples, its reference has shape {:?}",
                    s.recording.len(),
                    array.shape
                )))
            }
        })
        .collect()
}

/// The rows of a table `[names, samples]` that belong to the recordings; others may be there.
fn named_rows(
    table: &Array,
    names: &[String],
    subjects: &[Subject],
) -> Result<Vec<Vec<f64>>, String> {
    let row = |subject: &Subject| {
        let (name, samples) = (&subject.recording.name, subject.recording.len());
        let place = names.iter().position(|n| n == name);
        let place = place.ok_or_else(|| format!("`names` does not hold recording {name}"))?;
        if table.shape != [names.len() as u64, samples as u64] {
            return Err(format!(
                "`x` has shape {:?}; there are {} names, and recording {name} has {samples} samples",
                table.shape,
                names.len()
            ));
        }
        Ok(table.values[place * samples..][..samples].to_vec())
    };
    subjects.iter().map(row).collect()
}

/// The largest |x − reference| over all samples of all predicted recordings, mm.
pub(super) fn largest_error_mm(reference: &[Vec<f64>], measured: &Measured) -> f64 {
    let failed = |i: usize| measured.gradient.failures.iter().any(|f| f.problem == i);
    reference
        .iter()
        .zip(&measured.states)
        .enumerate()
        .filter(|(i, _)| !failed(*i))
        .flat_map(|(_, (reference, states))| {
            reference.iter().zip(states).map(|(r, s)| (s[0] - r).abs())
        })
        .fold(0.0, f64::max)
}
