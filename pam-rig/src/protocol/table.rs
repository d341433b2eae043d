//! Columns over time from a CSV file.

use crate::error::RigError;
use pam_data::DataError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A file with a column `time_s` and N further columns, held from row to row. Its path is relative to
/// the protocol's file. The values are kept with the protocol, so that a snapshot of it is complete.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table<const N: usize> {
    /// The file.
    pub file: PathBuf,
    /// Time of each row, s.
    #[serde(default, skip_deserializing)]
    time_s: Vec<f64>,
    /// Rows of the other columns.
    #[serde(default, skip_deserializing, with = "rows")]
    rows: Vec<[f64; N]>,
}

impl<const N: usize> Table<N> {
    /// A table from its columns.
    ///
    /// # Panics
    /// If there are not as many rows as times.
    #[must_use]
    pub fn new(time_s: Vec<f64>, rows: Vec<[f64; N]>) -> Self {
        assert_eq!(time_s.len(), rows.len());
        Self { file: PathBuf::new(), time_s, rows }
    }

    /// Reads the file, relative to `folder`; `columns` are `time_s` and the others.
    pub(super) fn load<const M: usize>(
        &mut self,
        folder: &Path,
        columns: [&str; M],
    ) -> Result<(), RigError> {
        let path = folder.join(&self.file);
        let values = pam_data::formats::csv_columns::read_columns(&path, columns)?;
        let [time_s, others @ ..] = &values[..] else {
            unreachable!("columns start with the time")
        };
        if time_s.len() < 2 {
            return Err(DataError::line(&path, 1, "a table needs at least two rows").into());
        }
        self.time_s.clone_from(time_s);
        self.rows = (0..time_s.len()).map(|i| std::array::from_fn(|c| others[c][i])).collect();
        Ok(())
    }

    /// Time from the first row to one step behind the last, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        match self.time_s[..] {
            [first, .., before, last] => 2.0 * last - before - first,
            [first, last] => 2.0 * (last - first),
            _ => 0.0,
        }
    }

    /// The row that holds at a time after the first row's.
    #[must_use]
    pub fn at(&self, t: f64) -> [f64; N] {
        let time = self.time_s[0] + t;
        // Half a nanosecond of tolerance against rounding of sample times.
        let after = self.time_s.partition_point(|&row| row <= time + 5e-10);
        self.rows[after.saturating_sub(1)]
    }

    /// Largest value of each column, `None` without rows.
    pub(super) fn largest(&self) -> Option<[f64; N]> {
        self.fold(f64::max)
    }

    /// Smallest value of each column.
    pub(super) fn smallest(&self) -> Option<[f64; N]> {
        self.fold(f64::min)
    }

    fn fold(&self, f: fn(f64, f64) -> f64) -> Option<[f64; N]> {
        let each = |a: [f64; N], b: [f64; N]| std::array::from_fn(|i| f(a[i], b[i]));
        self.rows.iter().copied().reduce(each)
    }
}

/// Rows as lists, because serde knows no arrays of generic length.
mod rows {
    use serde::Serializer;
    use serde::ser::SerializeSeq;

    pub(super) fn serialize<S: Serializer, const N: usize>(
        rows: &[[f64; N]],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(rows.len()))?;
        for row in rows {
            list.serialize_element(row.as_slice())?;
        }
        list.end()
    }
}
