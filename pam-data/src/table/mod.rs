//! Tables of numbers in files of any layout: text with any separator and decimal mark, `.npz`, `.mat`; with the cargo
//! features `parquet`, `mcap` and `hdf5` also Parquet files, MCAP logs and `.mat` files of MATLAB 7.3.
//!
//! A [`Table`] knows the names of its columns when it is opened, and reads those that are asked for.

mod arrays;
pub(crate) mod container;
mod delimited;
#[cfg(feature = "mcap")]
mod mcap_log;
#[cfg(feature = "parquet")]
mod parquet_file;
#[cfg(feature = "mcap")]
mod ros_message;

pub use delimited::DelimitedTable;

use crate::error::{DataError, read_bytes};
use crate::rig_file::FileLayout;
use arrays::ArrayTable;
use std::path::Path;

/// An opened table.
#[derive(Debug)]
pub enum Table {
    /// Text.
    Delimited(DelimitedTable),
    /// Named arrays of other files.
    Arrays(ArrayTable),
}

impl Table {
    /// Opens a table; `layout` says of text files what is not to be guessed.
    ///
    /// # Errors
    /// [`DataError`] if the file cannot be read, holds no table, or does not have this layout.
    pub fn open(path: &Path, layout: &FileLayout) -> Result<Self, DataError> {
        let bytes = read_bytes(path)?;
        if let Some(container) = container::of(&bytes) {
            return container.read(path, bytes, layout).map(Self::Arrays);
        }
        DelimitedTable::parse(path, bytes, layout).map(Self::Delimited)
    }

    /// Names of the columns, in the order of the file.
    #[must_use]
    pub fn names(&self) -> &[String] {
        match self {
            Self::Delimited(table) => table.names(),
            Self::Arrays(table) => table.names(),
        }
    }

    /// The line of text (counted from one) that names the columns, if there is one.
    #[must_use]
    pub fn header_line(&self) -> Option<u64> {
        match self {
            Self::Delimited(table) => table.header_line(),
            Self::Arrays(_) => None,
        }
    }

    /// The columns at these places, counted from zero.
    ///
    /// # Errors
    /// [`DataError`] naming the line and the column of the first cell that is no finite number, or columns of different
    /// lengths.
    pub fn columns(&self, places: &[usize]) -> Result<Vec<Vec<f64>>, DataError> {
        match self {
            Self::Delimited(table) => table.columns(places),
            Self::Arrays(table) => table.columns(places),
        }
    }

    /// Which columns hold finite numbers alone: those that [`columns`](Self::columns) reads.
    #[must_use]
    pub fn numeric(&self) -> Vec<bool> {
        match self {
            Self::Delimited(table) => table.numeric(),
            Self::Arrays(table) => {
                (0..self.names().len()).map(|k| table.columns(&[k]).is_ok()).collect()
            }
        }
    }

    /// How the table was made of the file, where that is not plain.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        match self {
            Self::Delimited(_) => &[],
            Self::Arrays(table) => table.notes(),
        }
    }

    /// The line of text that holds a row, both counted from one and zero; `None` if the table is not text.
    #[must_use]
    pub fn line_of_row(&self, row: usize) -> Option<u64> {
        match self {
            Self::Delimited(table) => table.line_of_row(row),
            Self::Arrays(_) => None,
        }
    }
}
