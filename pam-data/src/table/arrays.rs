//! Named arrays as a table.

use crate::error::DataError;
use std::path::{Path, PathBuf};

/// Named arrays of a file.
#[derive(Debug)]
pub struct ArrayTable {
    path: PathBuf,
    names: Vec<String>,
    arrays: Vec<Vec<f64>>,
    /// True if rows before the first with all numbers are left out.
    trimmed: bool,
    notes: Vec<String>,
}

impl ArrayTable {
    pub(super) fn new(path: &Path, arrays: Vec<(String, Vec<f64>)>) -> Self {
        let (names, arrays) = arrays.into_iter().unzip();
        Self { path: path.to_owned(), names, arrays, trimmed: false, notes: Vec::new() }
    }

    /// The table without the rows before all columns that are read have begun.
    #[cfg(feature = "mcap")]
    pub(super) fn starting_at_the_first_complete_row(mut self) -> Self {
        self.trimmed = true;
        self
    }

    /// Adds a sentence for the reader of the recordings.
    #[cfg(feature = "mcap")]
    pub(super) fn note(&mut self, note: String) {
        self.notes.push(note);
    }

    /// Sentences for the reader of the recordings.
    pub(super) fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Names of the arrays.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The arrays at these places.
    ///
    /// # Errors
    /// [`DataError`] if their lengths differ, or a number is not finite.
    pub fn columns(&self, places: &[usize]) -> Result<Vec<Vec<f64>>, DataError> {
        let lengths: Vec<usize> = places.iter().map(|&p| self.arrays[p].len()).collect();
        if lengths.windows(2).any(|w| w[0] != w[1]) {
            let sizes: Vec<String> = places
                .iter()
                .zip(&lengths)
                .map(|(&p, n)| format!("`{}` has {n}", self.names[p]))
                .collect();
            return Err(DataError::file(
                &self.path,
                format!("the arrays differ in length: {}", sizes.join(", ")),
            ));
        }
        let rows = lengths.first().copied().unwrap_or(0);
        let complete = |i: &usize| places.iter().all(|&p| !self.arrays[p][*i].is_nan());
        let first = if self.trimmed { (0..rows).find(complete).unwrap_or(0) } else { 0 };
        for &p in places {
            if let Some(i) = self.arrays[p].iter().skip(first).position(|v| !v.is_finite()) {
                let i = first + i;
                let (name, value) = (&self.names[p], self.arrays[p][i]);
                return Err(DataError::file(
                    &self.path,
                    format!("`{name}` is {value} at sample {i}"),
                ));
            }
        }
        Ok(places.iter().map(|&p| self.arrays[p][first..].to_vec()).collect())
    }
}
