//! MATLAB level 5 files: named arrays of real numbers.
//!
//! A file is a 128-byte header followed by data elements, each with a tag that holds its type and size. An array is an
//! element made of elements and is often zlib-compressed (The MathWorks, *MAT-File Format*, chapter 1).

use crate::error::{DataError, read_bytes};
use crate::read_limit::{largest_bytes, unpack};
use flate2::read::ZlibDecoder;
use std::collections::BTreeMap;
use std::path::Path;

/// Reads all numeric arrays of a `.mat` file, in column-major order. Character arrays, cells, structures, sparse
/// arrays and imaginary parts are skipped.
///
/// # Errors
/// [`DataError::File`] if the file is not level 5 or is damaged.
pub fn read(path: &Path) -> Result<BTreeMap<String, Vec<f64>>, DataError> {
    let bytes = read_bytes(path)?;
    if bytes.get(..8) == Some(b"\x89HDF\r\n\x1a\n") || bytes.starts_with(b"MATLAB 7.3") {
        return read_hdf5(path, bytes);
    }
    parse(&bytes).map_err(|why| DataError::file(path, why))
}

#[cfg(feature = "hdf5")]
fn read_hdf5(path: &Path, bytes: Vec<u8>) -> Result<BTreeMap<String, Vec<f64>>, DataError> {
    super::mat_hdf5::read(bytes).map_err(|why| DataError::file(path, why))
}

#[cfg(not(feature = "hdf5"))]
fn read_hdf5(path: &Path, _: Vec<u8>) -> Result<BTreeMap<String, Vec<f64>>, DataError> {
    Err(DataError::file(
        path,
        "a MATLAB 7.3 (HDF5) file, which this program was built without: save it again with `save(…, '-v7')`, or build the \
         program with `cargo build --release --features hdf5`",
    ))
}

const HEADER: usize = 128;
const TAG: usize = 8;
const TRUNCATED: &str = "the file ends inside an array; it is truncated";
// Data types of elements that are not numeric.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Numeric array classes: double, single and eight integer types.
const NUMERIC: std::ops::RangeInclusive<u8> = 6..=15;

fn parse(bytes: &[u8]) -> Result<BTreeMap<String, Vec<f64>>, String> {
    if !bytes.starts_with(b"MATLAB 5.0") {
        return Err("not a MATLAB level 5 file".into());
    }
    let big_endian = bytes.get(126..HEADER) == Some(b"MI");
    let mut file = Elements { rest: bytes.get(HEADER..).unwrap_or_default(), big_endian };
    if file.rest.is_empty() {
        return Err("a MATLAB file without arrays; it may be truncated".into());
    }
    let mut arrays = BTreeMap::new();
    let mut total = 0;
    while !file.rest.is_empty() {
        let unpacked;
        let (mut kind, mut content) = file.take()?;
        if kind == COMPRESSED {
            unpacked = unpack(ZlibDecoder::new(content))
                .map_err(|e| format!("an array cannot be unpacked ({e}); the file is damaged"))?;
            total += unpacked.len() as u64;
            if total > largest_bytes() {
                return Err(format!(
                    "its arrays take more than the {} MiB that are read (--max-read-mib)",
                    largest_bytes() >> 20
                ));
            }
            (kind, content) = Elements { rest: &unpacked, big_endian }.take()?;
        }
        if kind == MATRIX {
            arrays.extend(Elements { rest: content, big_endian }.array()?);
        }
    }
    Ok(arrays)
}

/// Consecutive data elements of a file or an array.
struct Elements<'a> {
    rest: &'a [u8],
    big_endian: bool,
}

impl<'a> Elements<'a> {
    /// Takes the type and content of the next element.
    fn take(&mut self) -> Result<(u32, &'a [u8]), String> {
        let word = |at: usize| {
            let bytes = self.rest.get(at..at + 4)?.try_into().ok()?;
            Some(if self.big_endian {
                u32::from_be_bytes(bytes)
            } else {
                u32::from_le_bytes(bytes)
            })
        };
        let first = word(0).ok_or(TRUNCATED)?;
        // Up to four bytes are stored inside the tag, with their size in the upper half of its first word.
        let (kind, start, size) = match first >> 16 {
            0 => (first, TAG, word(4).ok_or(TRUNCATED)? as usize),
            size => (first & 0xffff, TAG / 2, size as usize),
        };
        let content = start
            .checked_add(size)
            .and_then(|end| self.rest.get(start..end))
            .filter(|_| start == TAG || size <= TAG / 2)
            .ok_or(TRUNCATED)?;
        // Elements are padded to eight bytes, except compressed ones.
        let end = start + size;
        let end = if kind == COMPRESSED { end } else { end.next_multiple_of(TAG) };
        self.rest = &self.rest[end.min(self.rest.len())..];
        Ok((kind, content))
    }

    /// Reads these elements as an array: name and real part, or `None` if the array is not numeric.
    fn array(mut self) -> Result<Option<(String, Vec<f64>)>, String> {
        let (_, flags) = self.take()?;
        let class = *flags.get(if self.big_endian { 3 } else { 0 }).ok_or(TRUNCATED)?;
        if !NUMERIC.contains(&class) {
            return Ok(None);
        }
        let (_, _dimensions) = self.take()?;
        let (_, name) = self.take()?;
        let (kind, values) = self.take()?;
        let name = String::from_utf8_lossy(name).into_owned();
        let values = self.numbers(kind, values).ok_or_else(|| {
            format!("array `{name}` has values of unknown type {kind}; the file is damaged")
        })?;
        Ok(Some((name, values)))
    }

    /// Converts an element to doubles. MATLAB stores integer-valued doubles in the smallest integer type that fits.
    fn numbers(&self, kind: u32, content: &[u8]) -> Option<Vec<f64>> {
        macro_rules! all {
            ($type:ty) => {{
                const SIZE: usize = size_of::<$type>();
                let number = |bytes: &[u8; SIZE]| {
                    let number = if self.big_endian {
                        <$type>::from_be_bytes(*bytes)
                    } else {
                        <$type>::from_le_bytes(*bytes)
                    };
                    number as f64
                };
                Some(content.as_chunks::<SIZE>().0.iter().map(number).collect())
            }};
        }
        match kind {
            1 => all!(i8),
            2 => all!(u8),
            3 => all!(i16),
            4 => all!(u16),
            5 => all!(i32),
            6 => all!(u32),
            7 => all!(f32),
            9 => all!(f64),
            12 => all!(i64),
            13 => all!(u64),
            _ => None,
        }
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
