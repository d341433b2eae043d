//! Who works on a cell.
//!
//! A claim is a lock of the operating system on the file `claim` of the cell's folder
//! ([`File::try_lock`], `flock` on Unix). The system gives it up with the process, however the process
//! ends: a cell whose process was killed is free at once, and no claim is ever out of date. The file
//! stays, because a lock on a file that was deleted and made anew would be a lock on another file.
//!
//! Every line of the file is an event: a process began, stopped, finished or failed. A cell is over when
//! the last line says so. That is read under the lock, from the very file that is locked, so that it is
//! true on network file systems too, whose clients may show other files as they were some seconds ago.
//!
//! # What is relied on
//!
//! - Local disks: nothing but Linux or another system with `flock`.
//! - NFS: locks must reach the server. Linux clients send `flock` as byte-range locks of the whole file
//!   (since 2.6.12) unless the mount says `nolock` or `local_lock=flock` or `all`. When a node dies, NFSv4 frees
//!   its locks after the server's lease (90 s by default); NFSv3 when the node reports back.
//! - Lustre: mounted with `flock`, not `localflock`.
//!
//! [`check_locks`] checks if a second open file in the same process gets a lock that is held, which
//! catches file systems without locks, not those with locks of one node only.

use crate::error::AblateError;
use serde_json::{Value, json};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// A cell that this process alone works on, until the claim is dropped.
#[derive(Debug)]
pub struct Claim {
    file: File,
    path: PathBuf,
    attempts: usize,
}

/// Result of an attempt to lock a cell.
#[derive(Debug)]
pub enum Claimed {
    /// It is this process's.
    Mine(Claim),
    /// Somebody works on it.
    Elsewhere,
    /// It is over.
    Over,
}

const BEGAN: &str = "began";
const STOPPED: &str = "stopped";
const OVER: &str = "over";
const FREED: &str = "freed";

/// Opens a file for locking; folders that do not exist are made.
pub(crate) fn open(path: &Path) -> Result<File, AblateError> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| AblateError::io(folder, e))?;
    }
    let open = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
    open.map_err(|e| AblateError::io(path, e))
}

impl Claim {
    /// Claims the cell in a folder if it is free and not over.
    ///
    /// # Errors
    /// [`AblateError`] if the file cannot be opened, read or locked.
    pub fn take(folder: impl AsRef<Path>) -> Result<Claimed, AblateError> {
        let folder = folder.as_ref();
        Ok(match Self::lock(folder)? {
            None => Claimed::Elsewhere,
            Some((_, true)) => Claimed::Over,
            Some((claim, false)) => Claimed::Mine(claim),
        })
    }

    /// Makes a cell that is over free again, to be run from its start. Returns whether it was over and
    /// nobody worked on it.
    ///
    /// # Errors
    /// As [`take`](Self::take).
    pub fn free(folder: impl AsRef<Path>) -> Result<bool, AblateError> {
        let folder = folder.as_ref();
        let Some((mut claim, true)) = Self::lock(folder)? else { return Ok(false) };
        let work = folder.join("work");
        if work.exists() {
            std::fs::remove_dir_all(&work).map_err(|e| AblateError::io(&work, e))?;
        }
        let result = folder.join("result.json");
        if result.exists() {
            std::fs::remove_file(&result).map_err(|e| AblateError::io(&result, e))?;
        }
        claim.append(FREED)?;
        Ok(true)
    }

    /// The lock, and whether the cell is over.
    fn lock(folder: &Path) -> Result<Option<(Self, bool)>, AblateError> {
        let path = folder.join("claim");
        let mut file = open(&path)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(None),
            Err(TryLockError::Error(e)) => return Err(AblateError::io(&path, e)),
        }
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(|e| AblateError::io(&path, e))?;
        let events = events(&text);
        let attempts = events.iter().filter(|e| *e == BEGAN).count();
        let over = events.last().is_some_and(|e| e == OVER);
        if !text.is_empty() && !text.ends_with('\n') {
            file.write_all(b"\n").map_err(|e| AblateError::io(&path, e))?;
        }
        Ok(Some((Self { file, path, attempts }, over)))
    }

    /// How often work on the cell was begun.
    #[must_use]
    pub fn attempts(&self) -> usize {
        self.attempts
    }

    /// Notes that work begins.
    pub(crate) fn begin(&mut self) -> Result<(), AblateError> {
        self.attempts += 1;
        self.append(BEGAN)
    }

    /// Records that the cell was stopped and can be resumed.
    pub(crate) fn stopped(mut self) -> Result<(), AblateError> {
        self.append(STOPPED)
    }

    /// Notes that the cell is over. Its result must have been written.
    pub(crate) fn over(mut self) -> Result<(), AblateError> {
        self.append(OVER)
    }

    fn append(&mut self, event: &str) -> Result<(), AblateError> {
        let unix_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
        let line = json!({
            "event": event,
            "host": host(),
            "process": std::process::id(),
            "unix_s": unix_s,
        });
        let mut write = || {
            self.file.seek(SeekFrom::End(0))?;
            self.file.write_all(format!("{line}\n").as_bytes())?;
            self.file.sync_all()
        };
        write().map_err(|e| AblateError::io(&self.path, e))
    }
}

/// The events in the text of a claim. A line that was cut short by a crash is none; the next one begins
/// after it.
fn events(text: &str) -> Vec<String> {
    let event = |line: &str| {
        let value: Value = serde_json::from_str(line).ok()?;
        Some(value["event"].as_str()?.to_owned())
    };
    text.lines().filter_map(event).collect()
}

/// The events of a cell as they are seen without claiming it; none if its file cannot be read.
fn seen(folder: &Path) -> Vec<String> {
    std::fs::read_to_string(folder.join("claim")).map_or_else(|_| Vec::new(), |text| events(&text))
}

/// How often work on a cell was begun, without claiming it.
#[must_use]
pub fn attempts(folder: impl AsRef<Path>) -> usize {
    let folder = folder.as_ref();
    seen(folder).iter().filter(|e| *e == BEGAN).count()
}

/// True if a cell seems to be finished, without locking it.
#[must_use]
pub fn is_over(folder: impl AsRef<Path>) -> bool {
    let folder = folder.as_ref();
    seen(folder).last().is_some_and(|e| e == OVER)
}

/// Checks that the file system of a folder keeps locks apart.
///
/// # Errors
/// [`AblateError::Folder`] if it does not, or has none.
pub fn check_locks(folder: impl AsRef<Path>) -> Result<(), AblateError> {
    let folder = folder.as_ref();
    let path = folder.join(format!(".locks-{}-{}", host(), std::process::id()));
    let (first, second) = (open(&path)?, open(&path)?);
    let apart = first.try_lock().is_ok() && second.try_lock().is_err();
    let _ = std::fs::remove_file(&path);
    if apart {
        return Ok(());
    }
    Err(AblateError::folder(
        folder,
        "its file system has no locks, so that two processes could run the same cell; mount it with locks \
         (NFS: without nolock; Lustre: with flock)",
    ))
}

fn host() -> String {
    std::fs::read_to_string("/proc/sys/kernel/hostname")
        .map_or_else(|_| "unknown".to_owned(), |s| s.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_is_claimed_once_and_free_when_the_claim_ends() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        check_locks(at).unwrap();
        let Claimed::Mine(mut claim) = Claim::take(at).unwrap() else { panic!() };
        claim.begin().unwrap();
        assert!(matches!(Claim::take(at).unwrap(), Claimed::Elsewhere));
        drop(claim);
        // As after a crash in the middle of a line.
        let mut file = OpenOptions::new().append(true).open(at.join("claim")).unwrap();
        file.write_all(b"{\"event\":\"ov").unwrap();
        let Claimed::Mine(mut claim) = Claim::take(at).unwrap() else { panic!() };
        assert_eq!(claim.attempts(), 1);
        claim.begin().unwrap();
        claim.over().unwrap();
        assert!(matches!(Claim::take(at).unwrap(), Claimed::Over));
        assert_eq!(attempts(at), 2);
        assert!(Claim::free(at).unwrap());
        assert!(!Claim::free(at).unwrap());
        assert!(matches!(Claim::take(at).unwrap(), Claimed::Mine(_)));
    }
}
