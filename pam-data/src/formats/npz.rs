//! NumPy archives: named arrays of numbers.

use super::npy::{NpyError, read_npy, read_npy_texts, write_npy};
use crate::atomic::write_atomic;
use crate::error::DataError;
use crate::read_limit::{self, unpack};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Cursor, Read, Write};
use std::path::Path;

pub use super::npy::Array;

/// Opens an archive.
fn open(path: &Path, file: File) -> Result<zip::ZipArchive<File>, DataError> {
    zip::ZipArchive::new(file).map_err(|e| {
        DataError::file(path, format!("not a readable .npz archive ({e}); it may be truncated"))
    })
}

/// Names of the arrays of an `.npz` file; reads its directory only.
///
/// # Errors
/// [`DataError`] if the file cannot be read or is no archive.
pub fn names(path: &Path) -> Result<Vec<String>, DataError> {
    let file = read_limit::open(path)?;
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
    // Neither the file nor a member is held as a whole besides its numbers.
    let mut archive = open(path, read_limit::open(path)?)?;
    let mut arrays = BTreeMap::new();
    // All arrays are kept: together they may not exceed the limit either.
    let mut unpacked = 0;
    for i in 0..archive.len() {
        let mut file = archive.by_index(i).map_err(|e| fail(e.to_string()))?;
        let name =
            file.name().map_err(|e| fail(e.to_string()))?.trim_end_matches(".npy").to_owned();
        if !file.name().is_ok_and(|n| n.ends_with(".npy")) {
            continue;
        }
        let most = read_limit::largest_bytes().saturating_sub(unpacked).saturating_add(1);
        let mut source = (&mut file).take(most);
        let array = read_npy(&mut source);
        // The checksum is compared at the end.
        let rest = std::io::copy(&mut source, &mut std::io::sink());
        unpacked += most - source.limit();
        read_limit::check(path, unpacked)?;
        rest.map_err(|e| fail(format!("array `{name}` cannot be unpacked: {e}")))?;
        match array {
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
    let file = read_limit::open(path)?;
    let mut archive = open(path, file)?;
    let mut file = match archive.by_name(&format!("{name}.npy")) {
        Ok(file) => file,
        Err(zip::result::ZipError::FileNotFound) => return Ok(None),
        Err(e) => return Err(fail(e.to_string())),
    };
    let content = unpack(&mut file).map_err(|e| fail(e.to_string()))?;
    read_npy_texts(&mut content.as_slice()).map(Some).map_err(|e| fail(e.to_string()))
}

/// The text of a member that is no array; `None` if there is none of that name.
///
/// # Errors
/// [`DataError`] if the file is no archive or the member is no text.
pub fn read_member(path: &Path, name: &str) -> Result<Option<String>, DataError> {
    let file = read_limit::open(path)?;
    let mut archive = open(path, file)?;
    let mut file = match archive.by_name(name) {
        Ok(file) => file,
        Err(zip::result::ZipError::FileNotFound) => return Ok(None),
        Err(e) => return Err(DataError::file(path, format!("`{name}`: {e}"))),
    };
    let bytes = unpack(&mut file).map_err(|e| DataError::file(path, format!("`{name}`: {e}")))?;
    let text = String::from_utf8(bytes);
    text.map(Some).map_err(|e| DataError::file(path, format!("`{name}` is no text: {e}")))
}

/// Writes arrays as an uncompressed `.npz` file; the same arrays give the same bytes.
///
/// # Errors
/// [`DataError::Io`].
pub fn write(path: &Path, arrays: &BTreeMap<String, Array>) -> Result<(), DataError> {
    write_with(path, arrays, None)
}

/// [`write()`] with a member of text, by its name.
///
/// # Errors
/// [`DataError::Io`].
pub fn write_with(
    path: &Path,
    arrays: &BTreeMap<String, Array>,
    text: Option<(&str, &str)>,
) -> Result<(), DataError> {
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
    if let Some((name, text)) = text {
        archive.start_file(name, options).map_err(|e| DataError::file(path, e.to_string()))?;
        archive.write_all(text.as_bytes()).map_err(io)?;
    }
    let bytes = archive.finish().map_err(|e| DataError::file(path, e.to_string()))?.into_inner();
    write_atomic(path, &bytes)
}
