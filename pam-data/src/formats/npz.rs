//! NumPy archives: named arrays of numbers.

use crate::atomic::write_atomic;
use crate::error::{DataError, read_bytes};
use npyz::WriterBuilder;
use std::collections::BTreeMap;
use std::io::{Cursor, Read, Seek, Write};
use std::path::Path;
use thiserror::Error;

/// An array of doubles with its shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Length of each dimension; empty for a scalar.
    pub shape: Vec<u64>,
    /// Values in row-major order.
    pub values: Vec<f64>,
}

impl Array {
    /// A vector.
    #[must_use]
    pub fn vector(values: Vec<f64>) -> Self {
        Self { shape: vec![values.len() as u64], values }
    }

    /// A scalar.
    #[must_use]
    pub fn scalar(value: f64) -> Self {
        Self { shape: vec![], values: vec![value] }
    }
}

/// A `.npy` record that cannot be read as doubles.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NpyError {
    /// The record is damaged, cut short, or no record at all.
    #[error("{0}")]
    Damaged(String),
    /// The record holds something else than real numbers in a layout that is read.
    #[error("{0} are not supported; store float64 in C order")]
    Unsupported(String),
}

/// Reads one `.npy` record of real numbers (floats or integers) as doubles. Fortran order is turned
/// into row-major order.
///
/// # Errors
/// [`NpyError`] that says what is wrong.
pub fn read_npy(reader: &mut impl Read) -> Result<Array, NpyError> {
    let npy = npyz::NpyFile::new(reader)
        .map_err(|e| NpyError::Damaged(format!("not a .npy record: {e}")))?;
    let shape = npy.shape().to_vec();
    let fortran = npy.order() == npyz::Order::Fortran;
    let dtype = npy.dtype();
    let kind = dtype.descr();
    let mut values: Vec<f64> = if kind.contains("f8") {
        npy.into_vec::<f64>().map_err(|e| truncated(&e))?
    } else if kind.contains("f4") {
        npy.into_vec::<f32>().map_err(|e| truncated(&e))?.into_iter().map(f64::from).collect()
    } else if kind.contains("i8") {
        npy.into_vec::<i64>().map_err(|e| truncated(&e))?.into_iter().map(|v| v as f64).collect()
    } else if kind.contains("i4") {
        npy.into_vec::<i32>().map_err(|e| truncated(&e))?.into_iter().map(f64::from).collect()
    } else {
        return Err(NpyError::Unsupported(format!("numbers of type {kind}")));
    };
    if fortran && shape.len() == 2 {
        let (rows, columns) = (shape[0] as usize, shape[1] as usize);
        values = (0..rows)
            .flat_map(|r| (0..columns).map(move |c| c * rows + r))
            .map(|i| values[i])
            .collect();
    } else if fortran && shape.len() > 2 {
        return Err(NpyError::Unsupported("more than two dimensions in Fortran order".into()));
    }
    Ok(Array { shape, values })
}

fn truncated(error: &std::io::Error) -> NpyError {
    NpyError::Damaged(format!("the record ends early ({error}); the file may be truncated"))
}

/// Appends one `.npy` record of doubles.
///
/// # Errors
/// Errors of the writer.
pub fn write_npy(out: &mut impl Write, array: &Array) -> std::io::Result<()> {
    let mut writer =
        npyz::WriteOptions::new().default_dtype().shape(&array.shape).writer(out).begin_nd()?;
    writer.extend(array.values.iter().copied())?;
    writer.finish()
}

/// Opens an archive on bytes in memory or on a file.
fn open<R: Read + Seek>(path: &Path, reader: R) -> Result<zip::ZipArchive<R>, DataError> {
    zip::ZipArchive::new(reader).map_err(|e| {
        DataError::file(path, format!("not a readable .npz archive ({e}); it may be truncated"))
    })
}

/// Names of the arrays of an `.npz` file; reads its directory only.
///
/// # Errors
/// [`DataError`] if the file cannot be read or is no archive.
pub fn names(path: &Path) -> Result<Vec<String>, DataError> {
    let file = std::fs::File::open(path).map_err(|e| DataError::io(path, e))?;
    let archive = open(path, file)?;
    let names = archive.file_names().map(|n| n.map(|n| n.trim_end_matches(".npy").to_owned()));
    names.collect::<Result<_, _>>().map_err(|e| DataError::file(path, e.to_string()))
}

/// Reads all arrays of an `.npz` file that hold numbers; others are left out.
///
/// # Errors
/// [`DataError`] if the file is no archive or an array is damaged.
pub fn read(path: &Path) -> Result<BTreeMap<String, Array>, DataError> {
    let fail = |message: String| DataError::file(path, message);
    let mut archive = open(path, Cursor::new(read_bytes(path)?))?;
    let mut arrays = BTreeMap::new();
    for i in 0..archive.len() {
        let mut file = archive.by_index(i).map_err(|e| fail(e.to_string()))?;
        let name =
            file.name().map_err(|e| fail(e.to_string()))?.trim_end_matches(".npy").to_owned();
        if !file.name().is_ok_and(|n| n.ends_with(".npy")) {
            continue;
        }
        let mut content = Vec::new();
        file.read_to_end(&mut content)
            .map_err(|e| fail(format!("array `{name}` cannot be unpacked: {e}")))?;
        match read_npy(&mut content.as_slice()) {
            Ok(array) => {
                arrays.insert(name, array);
            }
            Err(NpyError::Unsupported(_)) => {}
            Err(e) => return Err(fail(format!("array `{name}`: {e}"))),
        }
    }
    Ok(arrays)
}

/// An array of Unicode strings of an `.npz` file, in row-major order; `None` if there is none of that name.
///
/// # Errors
/// [`DataError`] if the file is no archive, or the array is damaged or holds something else.
pub fn read_texts(path: &Path, name: &str) -> Result<Option<Vec<String>>, DataError> {
    let fail = |why: String| DataError::file(path, format!("array `{name}`: {why}"));
    // The other arrays may be large: only this one is read.
    let file = std::fs::File::open(path).map_err(|e| DataError::io(path, e))?;
    let mut archive = open(path, file)?;
    let mut file = match archive.by_name(&format!("{name}.npy")) {
        Ok(file) => file,
        Err(zip::result::ZipError::FileNotFound) => return Ok(None),
        Err(e) => return Err(fail(e.to_string())),
    };
    let mut content = Vec::new();
    file.read_to_end(&mut content).map_err(|e| fail(e.to_string()))?;
    let texts = npyz::NpyFile::new(content.as_slice()).and_then(|npy| npy.into_vec::<String>());
    texts.map(Some).map_err(|e| fail(format!("no array of Unicode strings: {e}")))
}

/// Writes arrays as an uncompressed `.npz` file; the same arrays give the same bytes.
///
/// # Errors
/// [`DataError::Io`].
pub fn write(path: &Path, arrays: &BTreeMap<String, Array>) -> Result<(), DataError> {
    let io = |e: std::io::Error| DataError::io(path, e);
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Stored)
        .last_modified_time(zip::DateTime::default());
    for (name, array) in arrays {
        archive
            .start_file(format!("{name}.npy"), options)
            .map_err(|e| DataError::file(path, e.to_string()))?;
        write_npy(&mut archive, array).map_err(io)?;
    }
    let bytes = archive.finish().map_err(|e| DataError::file(path, e.to_string()))?.into_inner();
    write_atomic(path, &bytes)
}
