//! Named arrays as a table.

use crate::error::DataError;
use std::path::{Path, PathBuf};

/// Named arrays of an `.npz` or `.mat` file.
#[derive(Debug)]
pub struct ArrayTable {
    path: PathBuf,
    names: Vec<String>,
    arrays: Vec<Vec<f64>>,
}

impl ArrayTable {
    pub(super) fn new(path: &Path, arrays: Vec<(String, Vec<f64>)>) -> Self {
        let (names, arrays) = arrays.into_iter().unzip();
        Self { path: path.to_owned(), names, arrays }
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
        for &p in places {
            if let Some(i) = self.arrays[p].iter().position(|v| !v.is_finite()) {
                let (name, value) = (&self.names[p], self.arrays[p][i]);
                return Err(DataError::file(
                    &self.path,
                    format!("`{name}` is {value} at sample {i}"),
                ));
            }
        }
        Ok(places.iter().map(|&p| self.arrays[p].clone()).collect())
    }
}
