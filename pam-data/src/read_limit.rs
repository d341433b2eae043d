//! Reading files with a largest size.
//!
//! Every reader of this crate opens files here. What is not a regular file is refused, because a pipe or a device may
//! never end; what is larger than [`largest_bytes`] is refused before memory is taken, and so is what an archive
//! unpacks to.

use crate::error::DataError;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// The size that was set; zero stands for the default.
static SET: AtomicU64 = AtomicU64::new(0);
/// The default, measured once.
static DEFAULT: OnceLock<u64> = OnceLock::new();

/// Largest default: ten million rows of six columns.
const MOST_BYTES: u64 = 512 << 20;
/// A recording is held as bytes, as columns, and filtered.
pub(crate) const COPIES: u64 = 6;
/// Taken where the operating system does not say how much memory there is.
const UNKNOWN_MEMORY: u64 = 4 << 30;

/// Largest number of bytes that is read from one file or unpacked from one archive: a sixth of the memory that was
/// available at the first call and at most 512 MiB, unless [`set_largest_bytes`] says otherwise.
#[must_use]
pub fn largest_bytes() -> u64 {
    match SET.load(Ordering::Relaxed) {
        0 => *DEFAULT.get_or_init(|| (available_bytes() / COPIES).min(MOST_BYTES)),
        set => set,
    }
}

/// Sets [`largest_bytes`] for the whole process; zero restores the default.
pub fn set_largest_bytes(bytes: u64) {
    SET.store(bytes, Ordering::Relaxed);
}

/// Memory that the process may still take: what is free, within the limits of its address space and control group.
#[must_use]
pub fn available_bytes() -> u64 {
    let text = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let number = |text: &str| text.split_whitespace().find_map(|w| w.parse::<u64>().ok());
    let meminfo = text("/proc/meminfo");
    let free = meminfo.lines().find(|line| line.starts_with("MemAvailable:"));
    let limits = text("/proc/self/limits");
    let address_space = limits.lines().find(|line| line.starts_with("Max address space"));
    let group = text("/sys/fs/cgroup/memory.max");
    [
        free.and_then(number).map(|kib| kib.saturating_mul(1024)),
        address_space.and_then(number),
        number(&group),
    ]
    .into_iter()
    .flatten()
    .min()
    .unwrap_or(UNKNOWN_MEMORY)
}

/// Opens a regular file that is not larger than [`largest_bytes`].
///
/// # Errors
/// [`DataError::Io`] if it cannot be opened, [`DataError::File`] if it is not a regular file or too large.
pub fn open(path: impl AsRef<Path>) -> Result<File, DataError> {
    let path = path.as_ref();
    // Before it is opened: to open a pipe that nobody writes to blocks.
    let metadata = std::fs::metadata(path).map_err(|e| DataError::io(path, e))?;
    if metadata.is_dir() {
        return Err(DataError::file(path, "this is a folder; give a file"));
    }
    if !metadata.is_file() {
        return Err(DataError::file(
            path,
            "not a regular file (a pipe, socket or device); save the data in a file",
        ));
    }
    check(path, metadata.len())?;
    File::open(path).map_err(|e| DataError::io(path, e))
}

/// Reads a whole file.
///
/// # Errors
/// As [`open`](fn@open).
pub fn read(path: impl AsRef<Path>) -> Result<Vec<u8>, DataError> {
    let path = path.as_ref();
    unpack(open(path)?).map_err(|why| match why {
        UnpackError::Io(source) => DataError::io(path, source),
        UnpackError::TooLarge(message) => DataError::file(path, message),
    })
}

/// Reads a whole file as text.
///
/// # Errors
/// As [`open`](fn@open), and [`DataError::Io`] if it is not UTF-8.
pub fn read_text(path: impl AsRef<Path>) -> Result<String, DataError> {
    let path = path.as_ref();
    String::from_utf8(read(path)?).map_err(|e| {
        DataError::io(path, std::io::Error::new(std::io::ErrorKind::InvalidData, e.utf8_error()))
    })
}

/// Why a member of an archive is not read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum UnpackError {
    /// It is damaged.
    #[error(transparent)]
    Io(std::io::Error),
    /// It is larger than allowed.
    #[error("{0}")]
    TooLarge(String),
}

/// Reads a source to its end, or until it exceeds [`largest_bytes`].
pub(crate) fn unpack(source: impl Read) -> Result<Vec<u8>, UnpackError> {
    let most = largest_bytes();
    let mut bytes = Vec::new();
    source.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(UnpackError::Io)?;
    if bytes.len() as u64 > most {
        return Err(UnpackError::TooLarge(too_large("more than the limit")));
    }
    Ok(bytes)
}

/// Refuses a size.
///
/// # Errors
/// [`DataError::File`] if it is above [`largest_bytes`].
pub(crate) fn check(path: &Path, bytes: u64) -> Result<(), DataError> {
    if bytes <= largest_bytes() {
        return Ok(());
    }
    Err(DataError::file(path, too_large(&format!("{:.0} MiB", mib(bytes)))))
}

/// Counts numbers that are parsed from text, whose doubles may take four times the bytes of the text.
#[derive(Debug)]
pub(crate) struct NumberBudget {
    left: u64,
}

impl NumberBudget {
    /// As many numbers as [`largest_bytes`] hold.
    pub(crate) fn new() -> Self {
        Self { left: largest_bytes() / size_of::<f64>() as u64 }
    }

    /// Takes so many numbers of a line.
    ///
    /// # Errors
    /// [`DataError::Line`] when there are too many.
    pub(crate) fn take(&mut self, path: &Path, line: u64, count: usize) -> Result<(), DataError> {
        self.left = self
            .left
            .checked_sub(count as u64)
            .ok_or_else(|| DataError::line(path, line, too_large("the table")))?;
        Ok(())
    }
}

fn too_large(size: &str) -> String {
    format!(
        "too large: {size} to read, at most {:.0} MiB are; cut the recording into parts, or raise the limit \
         (--max-read-mib)",
        mib(largest_bytes())
    )
}

fn mib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}
