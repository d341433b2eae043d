//! Arrays of a fitted baseline in an `.npz` file.

use crate::error::BaselineError;
use pam_data::DataError;
use pam_data::formats::npz::{self, Array};
use std::collections::BTreeMap;
use std::path::Path;

/// The arrays of a file by name. Names and shapes are those that
/// [`FittedModel::arrays`](crate::method::FittedModel::arrays) gives.
pub(crate) struct SavedArrays<'a> {
    path: &'a Path,
    arrays: BTreeMap<String, Array>,
}

impl<'a> SavedArrays<'a> {
    pub(crate) fn read(path: &'a Path) -> Result<Self, BaselineError> {
        Ok(Self { path, arrays: npz::read(path)? })
    }

    pub(crate) fn error(&self, message: String) -> BaselineError {
        DataError::file(self.path, message).into()
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.arrays.contains_key(name)
    }

    fn array(&self, name: &str) -> Result<&Array, BaselineError> {
        self.arrays.get(name).ok_or_else(|| {
            let names: Vec<&str> = self.arrays.keys().map(String::as_str).collect();
            self.error(format!("there is no array `{name}` among {}", names.join(", ")))
        })
    }

    /// Rows and columns of a matrix.
    pub(crate) fn rows_and_columns(&self, name: &str) -> Result<[usize; 2], BaselineError> {
        match self.array(name)?.shape[..] {
            [rows, columns] => Ok([rows as usize, columns as usize]),
            ref shape => {
                Err(self.error(format!("`{name}` has shape {shape:?}, not two dimensions")))
            }
        }
    }

    /// The values of an array of a given shape, row by row.
    pub(crate) fn values(&self, name: &str, shape: &[usize]) -> Result<&[f64], BaselineError> {
        let array = self.array(name)?;
        if array.shape.iter().map(|n| *n as usize).eq(shape.iter().copied()) {
            Ok(&array.values)
        } else {
            Err(self.error(format!("`{name}` has shape {:?}, not {shape:?}", array.shape)))
        }
    }

    /// The `N` numbers of an array, whatever its shape.
    pub(crate) fn numbers<const N: usize>(&self, name: &str) -> Result<[f64; N], BaselineError> {
        let values = &self.array(name)?.values;
        values[..].try_into().map_err(|_| {
            self.error(format!("`{name}` must hold {N} numbers, not {}", values.len()))
        })
    }

    /// A count of at least one.
    pub(crate) fn count(&self, name: &str) -> Result<usize, BaselineError> {
        let [value] = self.numbers(name)?;
        if value >= 1.0 && value.fract() == 0.0 && value < 1e9 {
            Ok(value as usize)
        } else {
            Err(self.error(format!("`{name}` is {value}, not a count")))
        }
    }

    /// A number that may be absent.
    pub(crate) fn optional(&self, name: &str) -> Result<Option<f64>, BaselineError> {
        self.has(name).then(|| self.numbers(name).map(|[value]| value)).transpose()
    }
}
