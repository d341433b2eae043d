//! The NumPy `.npy` format: one array, preceded by a header that is a Python dictionary (NEP 1, versions 1 to 3).

use std::io::{Read, Write};
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

/// Why an array could not be read.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NpyError {
    /// The bytes are truncated, corrupt or not in `.npy` format.
    #[error("{0}")]
    Damaged(String),
    /// The data type or memory layout is not supported.
    #[error("{0} are not supported; store float64 in C order")]
    Unsupported(String),
}

const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// The data start at a multiple of this many bytes.
const ALIGNMENT: usize = 64;

/// Reads an array of floats, integers or booleans as `f64`, converted to row-major order.
///
/// # Errors
/// [`NpyError`] if the bytes are not a complete array of a supported type.
pub fn read_npy(reader: &mut impl Read) -> Result<Array, NpyError> {
    let header = Header::read(reader)?;
    let (kind, size) = (header.kind, header.size);
    let convert: fn([u8; 8]) -> f64 = match (kind, size) {
        ('f', 8) => f64::from_le_bytes,
        ('f', 4) => |b| f64::from(f32::from_le_bytes(first(b))),
        ('i', 8) => |b| i64::from_le_bytes(b) as f64,
        ('i', 4) => |b| f64::from(i32::from_le_bytes(first(b))),
        ('i', 2) => |b| f64::from(i16::from_le_bytes(first(b))),
        ('i', 1) => |b| f64::from(i8::from_le_bytes(first(b))),
        ('u', 8) => |b| u64::from_le_bytes(b) as f64,
        ('u', 4) => |b| f64::from(u32::from_le_bytes(first(b))),
        ('u', 2) => |b| f64::from(u16::from_le_bytes(first(b))),
        ('u' | 'b', 1) => |b| f64::from(b[0]),
        _ => return Err(NpyError::Unsupported(format!("numbers of type {kind}{size}"))),
    };
    let bytes = header.read_items(reader)?;
    let mut values: Vec<f64> = bytes
        .chunks_exact(size)
        .map(|item| {
            let mut wide = [0; 8];
            wide[..size].copy_from_slice(item);
            if header.big_endian {
                wide[..size].reverse();
            }
            convert(wide)
        })
        .collect();
    if header.fortran_order && header.shape.len() == 2 {
        let (rows, columns) = (header.shape[0] as usize, header.shape[1] as usize);
        values = (0..rows)
            .flat_map(|r| (0..columns).map(move |c| c * rows + r))
            .map(|i| values[i])
            .collect();
    } else if header.fortran_order && header.shape.len() > 2 {
        return Err(NpyError::Unsupported("more than two dimensions in Fortran order".into()));
    }
    Ok(Array { shape: header.shape, values })
}

/// Reads an array of Unicode strings, in storage order.
///
/// # Errors
/// [`NpyError`] if the bytes are not a complete array of strings.
pub fn read_npy_texts(reader: &mut impl Read) -> Result<Vec<String>, NpyError> {
    let header = Header::read(reader)?;
    if header.kind != 'U' {
        let (kind, size) = (header.kind, header.size);
        return Err(NpyError::Damaged(format!(
            "expected Unicode strings, found type {kind}{size}"
        )));
    }
    let bytes = header.read_items(reader)?;
    let length = header.size / 4;
    let text = |i: usize| {
        let item = &bytes[i * header.size..(i + 1) * header.size];
        let mut text = String::with_capacity(length);
        for code in item.as_chunks::<4>().0 {
            let code = if header.big_endian {
                u32::from_be_bytes(*code)
            } else {
                u32::from_le_bytes(*code)
            };
            text.push(char::from_u32(code).ok_or_else(|| {
                NpyError::Damaged(format!(
                    "string {i} contains {code:#x}, which is not a Unicode character"
                ))
            })?);
        }
        text.truncate(text.trim_end_matches('\0').len());
        Ok(text)
    };
    (0..header.count()?).map(text).collect()
}

/// Writes an array of `f64`.
///
/// # Errors
/// I/O errors of `out`.
pub fn write_npy(out: &mut impl Write, array: &Array) -> std::io::Result<()> {
    write_header(out, "<f8", &array.shape)?;
    array.values.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))
}

/// Writes an array of `f32`.
///
/// # Errors
/// I/O errors of `out`.
pub fn write_npy_f32(out: &mut impl Write, shape: &[u64], values: &[f64]) -> std::io::Result<()> {
    write_header(out, "<f4", shape)?;
    values.iter().try_for_each(|v| out.write_all(&(*v as f32).to_le_bytes()))
}

fn write_header(out: &mut impl Write, descr: &str, shape: &[u64]) -> std::io::Result<()> {
    let lengths: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let lengths =
        if shape.len() == 1 { lengths.trim_end() } else { lengths.trim_end_matches(", ") };
    let mut text =
        format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({lengths}), }}");
    let before = MAGIC.len() + 4;
    let end = (before + text.len() + 1).next_multiple_of(ALIGNMENT);
    text.extend(std::iter::repeat_n(' ', end - before - text.len() - 1));
    text.push('\n');
    let length = u16::try_from(text.len()).map_err(|_| {
        std::io::Error::new(std::io::ErrorKind::InvalidInput, "the array has too many dimensions")
    })?;
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(text.as_bytes())
}

/// Data type, order and shape of the array.
struct Header {
    /// NumPy's type code: `f`, `i`, `u`, `b`, `U`, or another one that is not supported.
    kind: char,
    /// Bytes per item.
    size: usize,
    big_endian: bool,
    fortran_order: bool,
    shape: Vec<u64>,
}

impl Header {
    fn read(reader: &mut impl Read) -> Result<Self, NpyError> {
        let mut start = [0; 8];
        reader.read_exact(&mut start).map_err(|e| no_record(&e.to_string()))?;
        if start[..6] != *MAGIC {
            return Err(no_record("it does not begin with \\x93NUMPY"));
        }
        let length = match start[6] {
            1 => usize::from(u16::from_le_bytes(read_array(reader)?)),
            2 | 3 => u32::from_le_bytes(read_array(reader)?) as usize,
            version => return Err(no_record(&format!("its version is {version}"))),
        };
        let mut text = Vec::new();
        reader.take(length as u64).read_to_end(&mut text).map_err(|e| truncated(&e.to_string()))?;
        if text.len() < length {
            return Err(truncated("in its header"));
        }
        let text = std::str::from_utf8(&text).map_err(|e| no_record(&e.to_string()))?;
        Self::parse(text).ok_or_else(|| no_record(&format!("its header is `{}`", text.trim_end())))
    }

    /// Parses the dictionary, whose keys may be in any order.
    fn parse(text: &str) -> Option<Self> {
        let value = |key: &str| {
            let at = ['\'', '"'].iter().find_map(|q| {
                let quoted = format!("{q}{key}{q}");
                text.find(&quoted).map(|at| at + quoted.len())
            })?;
            text[at..].trim_start().strip_prefix(':').map(str::trim_start)
        };
        let descr = value("descr")?;
        let quote = descr.chars().next().filter(|&c| c == '\'' || c == '"');
        // A list instead of a string describes a structured array.
        let Some(quote) = quote else {
            let fields =
                Self { kind: 'V', size: 0, big_endian: false, fortran_order: false, shape: vec![] };
            return descr.starts_with('[').then_some(fields);
        };
        let descr = descr[1..].split(quote).next()?;
        let order = descr.chars().next().filter(|c| "<>=|".contains(*c));
        let rest = &descr[order.map_or(0, char::len_utf8)..];
        let kind = rest.chars().next()?;
        let digits = &rest[kind.len_utf8()..];
        // The size of a date is followed by its unit in brackets.
        let digits = digits.split('[').next()?;
        let size: usize = if digits.is_empty() { 0 } else { digits.parse().ok()? };
        let fortran_order = value("fortran_order")?;
        let shape = value("shape")?.strip_prefix('(')?.split(')').next()?;
        let lengths =
            shape.split(',').map(|n| n.trim().trim_end_matches('L')).filter(|n| !n.is_empty());
        Some(Self {
            kind,
            size: if kind == 'U' { size.checked_mul(4)? } else { size },
            big_endian: order == Some('>'),
            fortran_order: fortran_order.starts_with("True"),
            shape: lengths.map(|n| n.parse().ok()).collect::<Option<_>>()?,
        })
    }

    /// Number of items.
    fn count(&self) -> Result<usize, NpyError> {
        let count = self.shape.iter().try_fold(1_u64, |n, &length| n.checked_mul(length));
        count
            .and_then(|n| usize::try_from(n).ok())
            .ok_or_else(|| NpyError::Damaged(format!("its shape is {:?}", self.shape)))
    }

    /// Reads the bytes of all items.
    fn read_items(&self, reader: &mut impl Read) -> Result<Vec<u8>, NpyError> {
        let expected = (self.count()?)
            .checked_mul(self.size)
            .ok_or_else(|| NpyError::Damaged(format!("its shape is {:?}", self.shape)))?;
        // Nothing is preallocated, because a corrupt header can claim any length.
        let mut bytes = Vec::new();
        reader
            .take(expected as u64)
            .read_to_end(&mut bytes)
            .map_err(|e| truncated(&e.to_string()))?;
        if bytes.len() < expected {
            return Err(truncated(&format!("{} of {expected} bytes", bytes.len())));
        }
        Ok(bytes)
    }
}

fn first<const N: usize>(bytes: [u8; 8]) -> [u8; N] {
    std::array::from_fn(|i| bytes[i])
}

fn read_array<const N: usize>(reader: &mut impl Read) -> Result<[u8; N], NpyError> {
    let mut bytes = [0; N];
    reader.read_exact(&mut bytes).map_err(|e| truncated(&e.to_string()))?;
    Ok(bytes)
}

fn no_record(why: &str) -> NpyError {
    NpyError::Damaged(format!("not in .npy format: {why}"))
}

fn truncated(why: &str) -> NpyError {
    NpyError::Damaged(format!("the array ends early ({why}); the file may be truncated"))
}
