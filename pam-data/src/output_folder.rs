//! A folder that one program writes its results to.
//!
//! [`OutputFolder::claim`] is called before anything is computed: it makes the folder, finds out whether it can be
//! written, names what another command left there, takes a lock that the operating system gives up with the process
//! however it ends, and removes the temporary files of programs that were killed.

use crate::atomic::{TEMPORARY_PREFIX, remove_temporary};
use crate::document;
use crate::error::DataError;
use serde::Deserialize;
use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Name of the file that is locked; it is removed when the folder is released.
pub const LOCK_FILE: &str = ".lock-pam";

/// Name of the record of a run, from which the folder is known to hold the results of a command.
pub const RUN_RECORD: &str = "run.json";

/// Temporary files in a shared folder that are older than this belong to nobody.
const ABANDONED: Duration = Duration::from_secs(3600);
/// Depth of the folders that are searched for temporary files; the deepest one of a sweep is `cells/ID/work/stages`.
const DEPTH: usize = 8;

/// How many programs may work in a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sharing {
    /// One.
    Exclusive,
    /// Several of the same command, which agree among themselves.
    Shared,
}

/// A claimed folder; it is released when this is dropped. Folders that were made for it and are still empty are
/// removed again, so that a command that fails leaves nothing behind.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    lock: File,
    sharing: Sharing,
    made: Vec<PathBuf>,
}

#[derive(Deserialize)]
struct RunRecord {
    command: Option<String>,
}

impl OutputFolder {
    /// Claims the folder at a path for a command.
    ///
    /// # Errors
    /// [`DataError::Io`] if it cannot be made or written; [`DataError::File`] if another program writes there, or
    /// its [`RUN_RECORD`] is that of another command.
    pub fn claim(
        path: impl AsRef<Path>,
        command: &str,
        sharing: Sharing,
    ) -> Result<Self, DataError> {
        let path = path.as_ref();
        let mut made = Vec::new();
        for folder in path.ancestors().filter(|p| !p.as_os_str().is_empty()) {
            if folder.exists() {
                break;
            }
            made.push(folder.to_owned());
        }
        std::fs::create_dir_all(path).map_err(|e| DataError::io(path, e))?;
        // Who comes first to a shared folder is alone in it for a moment, and cleans it up.
        let alone = lock(path, Sharing::Exclusive);
        let is_alone = alone.is_ok();
        let locked = match sharing {
            Sharing::Exclusive => alone,
            Sharing::Shared => {
                if is_alone {
                    remove_temporary(path, DEPTH, Duration::ZERO);
                }
                drop(alone);
                lock(path, Sharing::Shared)
            }
        };
        let lock = locked.inspect_err(|_| remove_empty(&made))?;
        let claimed = Self { path: path.to_owned(), lock, sharing, made };
        claimed.check_owner(command)?;
        match sharing {
            Sharing::Exclusive => remove_temporary(path, DEPTH, Duration::ZERO),
            Sharing::Shared => remove_temporary(path, DEPTH, ABANDONED),
        }
        Ok(claimed)
    }

    fn check_owner(&self, command: &str) -> Result<(), DataError> {
        let record = self.path.join(RUN_RECORD);
        let Ok(text) = crate::read_limit::read_text(&record) else { return Ok(()) };
        // A record that is not ours says nothing about a command.
        let Ok(RunRecord { command: Some(owner) }) = document::from_json(&text) else {
            return Err(DataError::file(
                &self.path,
                "holds a run.json that this program did not write; give another folder",
            ));
        };
        if owner == command {
            return Ok(());
        }
        Err(DataError::file(
            &self.path,
            format!(
                "holds the results of `pam {owner}`, which `pam {command}` would replace; give another folder"
            ),
        ))
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        // Nobody else may hold it: of a shared lock only the last one removes the file.
        let alone = match self.sharing {
            Sharing::Exclusive => true,
            Sharing::Shared => self.lock.unlock().is_ok() && self.lock.try_lock().is_ok(),
        };
        if alone {
            let _ = std::fs::remove_file(self.path.join(LOCK_FILE));
            remove_empty(&self.made);
        }
    }
}

/// Checks that a file can be written, and removes what killed programs left beside it; nothing is left behind.
///
/// # Errors
/// [`DataError::Io`] if its folder cannot be made or written, [`DataError::File`] if the path is a folder.
pub fn check_file(path: impl AsRef<Path>) -> Result<(), DataError> {
    let path = path.as_ref();
    if path.is_dir() {
        return Err(DataError::file(path, "this is a folder; name a file to write"));
    }
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    // Of folders that do not exist, the nearest one that does must take them.
    let Some(there) = folder.ancestors().find(|p| p.as_os_str().is_empty() || p.exists()) else {
        return Ok(());
    };
    let there = if there.as_os_str().is_empty() { Path::new(".") } else { there };
    let probe = tempfile::Builder::new().prefix(TEMPORARY_PREFIX).tempfile_in(there);
    drop(probe.map_err(|e| DataError::io(path, e))?);
    remove_temporary(folder, 1, ABANDONED);
    Ok(())
}

fn lock(folder: &Path, sharing: Sharing) -> Result<File, DataError> {
    let path = folder.join(LOCK_FILE);
    loop {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(|e| DataError::io(folder, e))?;
        let taken = match sharing {
            Sharing::Exclusive => file.try_lock(),
            Sharing::Shared => file.try_lock_shared(),
        };
        match taken {
            Ok(()) if is_at(&file, &path) => return Ok(file),
            // It was removed by the program that held it between opening and locking.
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(DataError::file(
                    folder,
                    "another program is writing its results there; wait for it, or give another folder",
                ));
            }
            Err(TryLockError::Error(e)) if e.kind() == std::io::ErrorKind::Unsupported => {
                // Without locks the other checks still hold.
                return Ok(file);
            }
            Err(TryLockError::Error(e)) => return Err(DataError::io(folder, e)),
        }
    }
}

#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let id = |m: std::fs::Metadata| (m.dev(), m.ino());
    let (open, there) = (file.metadata().map(id), std::fs::metadata(path).map(id));
    open.is_ok_and(|open| there.is_ok_and(|there| open == there))
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

/// Removes folders that are empty, innermost first.
fn remove_empty(folders: &[PathBuf]) {
    for folder in folders {
        if std::fs::remove_dir(folder).is_err() {
            break;
        }
    }
}
