//! Files that are either complete or absent.

use crate::error::DataError;
use std::io::Write;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// How the names of files begin that are being written. A program that is killed may leave them.
pub const TEMPORARY_PREFIX: &str = ".pam-";

/// Writes `bytes` to `path`: into a temporary file in the same folder that is then renamed, so that no reader
/// and no crash ever sees half a file. Folders that do not exist are made.
///
/// # Errors
/// [`DataError::Io`] naming the path.
pub fn write_atomic(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), DataError> {
    write_atomic_at(path.as_ref(), bytes)
}

/// As [`write_atomic`], to a path at which nothing is yet.
///
/// # Errors
/// [`DataError::Io`] naming the path, of the kind `AlreadyExists` if there is something at it.
pub fn write_new(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), DataError> {
    let path = path.as_ref();
    let io = |e: std::io::Error| DataError::io(path, e);
    temporary(path, bytes).map_err(io)?.persist_noclobber(path).map_err(|e| io(e.error))?;
    Ok(())
}

/// One instance, whatever the path is given as.
fn write_atomic_at(path: &Path, bytes: &[u8]) -> Result<(), DataError> {
    let io = |e: std::io::Error| DataError::io(path, e);
    temporary(path, bytes).map_err(io)?.persist(path).map_err(|e| io(e.error))?;
    Ok(())
}

/// A temporary file beside a path that holds `bytes`.
fn temporary(path: &Path, bytes: &[u8]) -> std::io::Result<tempfile::NamedTempFile> {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::Builder::new()
        .prefix(TEMPORARY_PREFIX)
        .permissions(default_permissions())
        .tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    Ok(file)
}

#[cfg(unix)]
fn default_permissions() -> std::fs::Permissions {
    use std::os::unix::fs::PermissionsExt;
    // The process's umask still applies when the file is made.
    std::fs::Permissions::from_mode(0o666)
}

#[cfg(not(unix))]
fn default_permissions() -> std::fs::Permissions {
    std::fs::metadata(".").expect("the working folder exists").permissions()
}

/// Removes the temporary files that killed programs left in the top `depth` levels of a folder, if they are at least `age` old. Files that
/// cannot be removed stay.
pub fn remove_temporary(folder: &Path, depth: usize, age: Duration) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let Ok(kind) = entry.file_type() else { continue };
        if kind.is_dir() && depth > 1 {
            remove_temporary(&entry.path(), depth - 1, age);
        } else if kind.is_file()
            && entry.file_name().to_string_lossy().starts_with(TEMPORARY_PREFIX)
            && is_older(&entry, age)
        {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

fn is_older(entry: &std::fs::DirEntry, age: Duration) -> bool {
    age.is_zero()
        || entry
            .metadata()
            .and_then(|m| m.modified())
            .is_ok_and(|at| SystemTime::now().duration_since(at).is_ok_and(|since| since >= age))
}
