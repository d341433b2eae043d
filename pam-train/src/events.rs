//! TensorBoard event files of scalars.
//!
//! A file is a sequence of records in TensorFlow's framing: the length of the data (8 bytes, little
//! endian), the masked CRC-32C of these 8 bytes, the data, and the masked CRC-32C of the data. The
//! data are messages `Event` of `tensorflow/core/util/event.proto` in protobuf's wire format. The first
//! holds the version of the file; each other one scalar.
//!
//! TensorBoard takes a file for its own if its name contains `tfevents`, as [`EVENT_FILE_NAME`] does.

use pam_data::DataError;
use pam_data::atomic::write_atomic;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// A name by which TensorBoard finds an event file in its folder.
pub const EVENT_FILE_NAME: &str = "events.out.tfevents.pam";

/// Content of the first record of every file.
const FILE_VERSION: &str = "brain.Event:2";

/// One value of a curve: the curve's name, where on it (an epoch for example), when (s since 1970),
/// and the value, in the precision that the file holds.
pub type ScalarEvent = (String, i64, f64, f32);

/// An event file that grows.
#[derive(Debug)]
pub struct EventFile {
    path: PathBuf,
    file: BufWriter<File>,
}

impl EventFile {
    /// Starts a file, replacing one that is there. Folders that do not exist are made.
    ///
    /// # Errors
    /// [`DataError::Io`] naming the path.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, DataError> {
        let path = path.as_ref();
        Self::rewrite(path, &[])
    }

    /// Replaces the file by one of these scalars, in one step, and opens it to grow. A run that is
    /// resumed thus leaves behind neither half a record nor what it is about to repeat.
    ///
    /// # Errors
    /// [`DataError::Io`] naming the path.
    pub fn rewrite(path: impl AsRef<Path>, scalars: &[ScalarEvent]) -> Result<Self, DataError> {
        let path = path.as_ref();
        let started_s = scalars.first().map_or_else(now_s, |s| s.2);
        let mut bytes = record(&version_event(started_s));
        for (tag, step, wall_time_s, value) in scalars {
            bytes.extend(record(&scalar_event(tag, *step, *wall_time_s, *value)));
        }
        write_atomic(path, &bytes)?;
        let io = |source| DataError::Io { path: path.to_owned(), source };
        let file = OpenOptions::new().append(true).open(path).map_err(io)?;
        Ok(Self { path: path.to_owned(), file: BufWriter::new(file) })
    }

    /// Adds a value to the curve `tag`. It may stay in memory until [`flush`](Self::flush).
    ///
    /// # Errors
    /// [`DataError::Io`] naming the path.
    pub fn scalar(
        &mut self,
        tag: &str,
        step: i64,
        wall_time_s: f64,
        value: f32,
    ) -> Result<(), DataError> {
        let bytes = record(&scalar_event(tag, step, wall_time_s, value));
        self.file.write_all(&bytes).map_err(|source| self.failed(source))
    }

    /// Hands everything to the operating system, so that TensorBoard sees it.
    ///
    /// # Errors
    /// [`DataError::Io`] naming the path.
    pub fn flush(&mut self) -> Result<(), DataError> {
        self.file.flush().map_err(|source| self.failed(source))
    }

    fn failed(&self, source: std::io::Error) -> DataError {
        DataError::Io { path: self.path.clone(), source }
    }
}

/// The time, s since 1970.
fn now_s() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64())
}

/// `Event { wall_time = 1, file_version = 3 }`.
fn version_event(wall_time_s: f64) -> Vec<u8> {
    let mut event = Vec::new();
    push_fixed64(&mut event, 1, wall_time_s);
    push_bytes(&mut event, 3, FILE_VERSION.as_bytes());
    event
}

/// `Event { wall_time = 1, step = 2, summary = 5 }` with `Summary { value = 1 }` and
/// `Value { tag = 1, simple_value = 2 }`.
fn scalar_event(tag: &str, step: i64, wall_time_s: f64, value: f32) -> Vec<u8> {
    let mut inner = Vec::new();
    push_bytes(&mut inner, 1, tag.as_bytes());
    push_key(&mut inner, 2, 5);
    inner.extend(value.to_le_bytes());
    let mut summary = Vec::new();
    push_bytes(&mut summary, 1, &inner);
    let mut event = Vec::new();
    push_fixed64(&mut event, 1, wall_time_s);
    push_key(&mut event, 2, 0);
    push_varint(&mut event, step as u64);
    push_bytes(&mut event, 5, &summary);
    event
}

/// Number of a field and how its content is written: 0 varint, 1 eight bytes, 2 a length and as many
/// bytes, 5 four bytes.
fn push_key(out: &mut Vec<u8>, field: u64, wire: u64) {
    push_varint(out, field << 3 | wire);
}

fn push_varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push((value & 0x7f) as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn push_fixed64(out: &mut Vec<u8>, field: u64, value: f64) {
    push_key(out, field, 1);
    out.extend(value.to_le_bytes());
}

fn push_bytes(out: &mut Vec<u8>, field: u64, bytes: &[u8]) {
    push_key(out, field, 2);
    push_varint(out, bytes.len() as u64);
    out.extend(bytes);
}

fn record(data: &[u8]) -> Vec<u8> {
    let length = (data.len() as u64).to_le_bytes();
    let mut out = Vec::with_capacity(data.len() + 16);
    out.extend(length);
    out.extend(masked(crc32c(&length)).to_le_bytes());
    out.extend(data);
    out.extend(masked(crc32c(data)).to_le_bytes());
    out
}

/// A checksum as the framing stores it.
fn masked(crc: u32) -> u32 {
    crc.rotate_right(15).wrapping_add(0xa282_ead8)
}

/// CRC-32C (Castagnoli), the reflected polynomial 0x82f63b78.
fn crc32c(data: &[u8]) -> u32 {
    const TABLE: [u32; 256] = {
        let mut table = [0; 256];
        let mut k = 0;
        while k < 256 {
            let (mut crc, mut bit) = (k as u32, 0);
            while bit < 8 {
                crc = if crc & 1 == 1 { crc >> 1 ^ 0x82f6_3b78 } else { crc >> 1 };
                bit += 1;
            }
            table[k] = crc;
            k += 1;
        }
        table
    };
    !data.iter().fold(!0, |crc, b| crc >> 8 ^ TABLE[(crc as u8 ^ b) as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vectors of RFC 3720, appendix B.4, and the check value of the catalogue of CRCs.
    #[test]
    fn the_checksum_is_crc_32c() {
        let ascending: Vec<u8> = (0..32).collect();
        let descending: Vec<u8> = (0..32).rev().collect();
        assert_eq!(crc32c(b"123456789"), 0xe306_9283);
        assert_eq!(crc32c(&[0; 32]), 0x8a91_36aa);
        assert_eq!(crc32c(&[0xff; 32]), 0x62a8_ab43);
        assert_eq!(crc32c(&ascending), 0x46dd_794e);
        assert_eq!(crc32c(&descending), 0x113f_db5c);
        assert_eq!(crc32c(b""), 0);
    }
}
