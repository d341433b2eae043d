//! MATLAB level 5 files: named arrays of real numbers.

use crate::error::{DataError, read_bytes};
use matfile::{MatFile, NumericData};
use std::collections::BTreeMap;
use std::path::Path;

/// Reads all real arrays of a `.mat` file, column-major as MATLAB stores them.
///
/// # Errors
/// [`DataError::File`] if the file is not level 5 or is damaged.
pub fn read(path: &Path) -> Result<BTreeMap<String, Vec<f64>>, DataError> {
    let bytes = read_bytes(path)?;
    if bytes.get(..8) == Some(b"\x89HDF\r\n\x1a\n") || bytes.starts_with(b"MATLAB 7.3") {
        return Err(DataError::file(
            path,
            "a MATLAB 7.3 (HDF5) file; save it again with `save(…, '-v7')`",
        ));
    }
    check_complete(&bytes).map_err(|why| DataError::file(path, why))?;
    let parsed = std::panic::catch_unwind(|| MatFile::parse(bytes.as_slice()))
        .map_err(|_| DataError::file(path, "a damaged MATLAB file"))?;
    let file = parsed.map_err(|e| {
        DataError::file(
            path,
            format!("not a readable MATLAB level 5 file ({e}); it may be truncated"),
        )
    })?;
    Ok(file.arrays().iter().map(|a| (a.name().to_owned(), to_f64(a.data()))).collect())
}

/// Walks the elements of a level 5 file: the parser takes a file that ends inside an element for one
/// that ends before it.
fn check_complete(bytes: &[u8]) -> Result<(), String> {
    const HEADER: usize = 128;
    const TAG: usize = 8;
    if !bytes.starts_with(b"MATLAB 5.0") {
        return Err("not a MATLAB level 5 file".into());
    }
    let big_endian = bytes.get(126..HEADER) == Some(b"MI");
    let mut at = HEADER;
    while at < bytes.len() {
        let tag: Option<[u8; 4]> = bytes.get(at + 4..at + TAG).and_then(|b| b.try_into().ok());
        let end = tag
            .map(|b| if big_endian { u32::from_be_bytes(b) } else { u32::from_le_bytes(b) })
            .and_then(|size| (at + TAG).checked_add(size as usize))
            .filter(|&end| end <= bytes.len())
            .ok_or("the file ends inside an array; it is truncated")?;
        at = end;
    }
    if at == HEADER {
        Err("a MATLAB file without arrays; it may be truncated".into())
    } else {
        Ok(())
    }
}

fn to_f64(data: &NumericData) -> Vec<f64> {
    fn all<T: Copy>(values: &[T], f: impl Fn(T) -> f64) -> Vec<f64> {
        values.iter().map(|&v| f(v)).collect()
    }
    match data {
        NumericData::Int8 { real, .. } => all(real, f64::from),
        NumericData::UInt8 { real, .. } => all(real, f64::from),
        NumericData::Int16 { real, .. } => all(real, f64::from),
        NumericData::UInt16 { real, .. } => all(real, f64::from),
        NumericData::Int32 { real, .. } => all(real, f64::from),
        NumericData::UInt32 { real, .. } => all(real, f64::from),
        NumericData::Int64 { real, .. } => all(real, |v| v as f64),
        NumericData::UInt64 { real, .. } => all(real, |v| v as f64),
        NumericData::Single { real, .. } => all(real, f64::from),
        NumericData::Double { real, .. } => real.clone(),
    }
}

/// One array by name.
///
/// # Errors
/// [`DataError::File`] naming the arrays that exist.
pub(crate) fn take<'a>(
    path: &Path,
    arrays: &'a BTreeMap<String, Vec<f64>>,
    name: &str,
    purpose: &str,
) -> Result<&'a [f64], DataError> {
    arrays.get(name).map(Vec::as_slice).ok_or_else(|| {
        let present = arrays.keys().cloned().collect::<Vec<_>>().join(", ");
        DataError::file(
            path,
            format!("array `{name}` is missing for {purpose}; the arrays here are [{present}]"),
        )
    })
}
