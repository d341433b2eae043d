//! Opens any supported file by its content.

use crate::error::DataError;
use crate::formats::list::format_of;
use crate::load_options::LoadOptions;
use crate::preprocess::refilter;
use crate::recording::Recording;
use crate::rig_file::RigFile;
use crate::table::Table;
use pam_core::parallel;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How the names of files end that hold the truth behind a made-up log. They are sealed:
/// [`open_recordings`] refuses them and folders are expanded without them.
pub const TRUTH_SUFFIX: &str = ".truth.npz";

fn is_truth(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().ends_with(TRUTH_SUFFIX))
}

/// Hidden files, among them those that a killed program left half written.
fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'))
}

/// Reads the recordings of one file: one, or several if it has gaps.
///
/// # Errors
/// [`DataError`] naming file, line and column.
pub fn open_recordings(
    path: impl AsRef<Path>,
    options: &LoadOptions,
) -> Result<Vec<Recording>, DataError> {
    open_recordings_at(path.as_ref(), options)
}

/// One instance, whatever the path is given as.
fn open_recordings_at(path: &Path, options: &LoadOptions) -> Result<Vec<Recording>, DataError> {
    let mut recordings = read_whole(path, options)?;
    if options.filtered_force_only {
        recordings.iter_mut().for_each(|r| r.low_passed.force_mn = None);
    }
    Ok(recordings)
}

fn read_whole(path: &Path, options: &LoadOptions) -> Result<Vec<Recording>, DataError> {
    if is_truth(path) {
        return Err(DataError::file(
            path,
            "this is the sealed truth behind a made-up log; give the log itself",
        ));
    }
    if let Some(rig) = options.rig.as_ref().filter(|rig| rig.columns.is_some()) {
        let table = Table::open(path, &rig.file)?;
        if rig.describes(&table) {
            if let Some(key) = options.unused_raw_log_option() {
                let message = format!(
                    "the loader's option `{key}` is for raw logs; the rig file describes this file: set it there"
                );
                return Err(DataError::file(path, message));
            }
            return rig.recordings_of(&table, path, options);
        }
    }
    let format = format_of(path)?;
    if let Some(key) = options.unused_raw_log_option().filter(|_| !format.filters_channels()) {
        let message = format!(
            "the loader's option `{key}` is for raw logs and does nothing here: this is {}. Describe units and sizes in a \
             rig file (--rig-file), or leave the option out",
            format.name()
        );
        return Err(DataError::file(path, message));
    }
    let mut taken = format.read_recordings(path, &options.of_rig())?;
    if let Some(rig) = &options.rig {
        let rig = Arc::new(rig.sizes());
        taken.iter_mut().for_each(|r| r.rig = Some(rig.clone()));
    }
    if !options.preprocess || format.filters_channels() {
        return Ok(taken);
    }
    taken.into_iter().map(|r| refilter(r, options.raw_log.cutoff_hz)).collect()
}

/// Reads all recordings of some files and folders (see [`collect_paths`] and [`read_files`]), as the commands do.
///
/// ```no_run
/// let recordings = pam_data::read_recordings(["logs"], &pam_data::LoadOptions::default())?;
/// # Ok::<(), pam_data::DataError>(())
/// ```
///
/// # Errors
/// [`DataError`] naming file, line and column.
pub fn read_recordings<P: AsRef<Path>>(
    paths: impl IntoIterator<Item = P>,
    options: &LoadOptions,
) -> Result<Vec<Recording>, DataError> {
    let paths: Vec<PathBuf> = paths.into_iter().map(|p| p.as_ref().to_owned()).collect();
    read_files(&collect_paths_of(&paths, options.rig.as_ref())?, options, &|| {})
}

/// Reads the recordings of files in parallel and returns them in the order of the files, each with a name of its
/// own: a second recording `nn_3060` becomes `nn_3060~2`. `read` is called after each file.
///
/// # Errors
/// [`DataError`] naming file, line and column.
pub fn read_files(
    paths: &[impl AsRef<Path> + Sync],
    options: &LoadOptions,
    read: &(dyn Fn() + Sync),
) -> Result<Vec<Recording>, DataError> {
    read_files_at(&as_paths(paths), options, read)
}

/// Paths of one type: what follows has then one instance, whatever the paths are given as.
fn as_paths(paths: &[impl AsRef<Path>]) -> Vec<&Path> {
    paths.iter().map(AsRef::as_ref).collect()
}

fn read_files_at(
    paths: &[&Path],
    options: &LoadOptions,
    read: &(dyn Fn() + Sync),
) -> Result<Vec<Recording>, DataError> {
    let files: Vec<Result<Vec<Recording>, DataError>> = parallel::map(paths.len(), |k| {
        let recordings = open_recordings_at(paths[k], options);
        read();
        recordings
    });
    let mut all: Vec<Recording> = Vec::new();
    for recordings in files {
        for mut recording in recordings? {
            let taken = |name: &str| all.iter().any(|r| r.name == name);
            if taken(&recording.name) {
                let base = recording.name.clone();
                let free = (2..).map(|k| format!("{base}~{k}")).find(|name| !taken(name));
                recording.name = free.unwrap_or(base);
            }
            all.push(recording);
        }
    }
    Ok(all)
}

/// The rig that some files, and the recordings in some folders, name as the one they were made on; `None` if no file names
/// one.
///
/// # Errors
/// [`DataError`] if two files name rigs of different sizes.
pub fn rig_of<P: AsRef<Path>>(paths: &[P]) -> Result<Option<RigFile>, DataError> {
    rig_of_paths(&as_paths(paths))
}

fn rig_of_paths(paths: &[&Path]) -> Result<Option<RigFile>, DataError> {
    let mut found: Option<(PathBuf, RigFile)> = None;
    // Folders and files that cannot be read are reported where they are read.
    let expand = |&path: &&Path| collect_paths(&[path]).unwrap_or_default();
    for path in paths.iter().flat_map(expand) {
        let Ok(format) = format_of(&path) else { continue };
        let Ok(Some(rig)) = format.rig(&path) else { continue };
        match &found {
            Some((first, known)) if *known != rig => {
                let message = format!(
                    "the rig of this recording is not that of {}: give recordings of one rig, or the rig file that holds \
                     for all with --rig-file",
                    first.display()
                );
                return Err(DataError::file(&path, message));
            }
            Some(_) => {}
            None => found = Some((path, rig)),
        }
    }
    Ok(found.map(|(_, rig)| rig))
}

/// Expands folders into the recordings they hold (not recursively), sorted by name; files are kept
/// as given. Hidden files and files of other kinds inside a folder are passed over.
///
/// # Errors
/// [`DataError`] if a path cannot be read or a folder holds no recording.
pub fn collect_paths(paths: &[impl AsRef<Path>]) -> Result<Vec<PathBuf>, DataError> {
    collect_paths_of(paths, None)
}

/// [`collect_paths`] with the files of a rig: in folders all tables that hold its columns are recordings besides.
///
/// # Errors
/// As [`collect_paths`].
pub fn collect_paths_of(
    paths: &[impl AsRef<Path>],
    rig: Option<&RigFile>,
) -> Result<Vec<PathBuf>, DataError> {
    collect(&as_paths(paths), rig)
}

fn collect(paths: &[&Path], rig: Option<&RigFile>) -> Result<Vec<PathBuf>, DataError> {
    let mut out = Vec::new();
    for &path in paths {
        if !path.is_dir() {
            out.push(path.to_owned());
            continue;
        }
        let io = |e: std::io::Error| DataError::io(path, e);
        let mut found = Vec::new();
        for entry in std::fs::read_dir(path).map_err(io)? {
            let file = entry.map_err(io)?.path();
            let holds_recording = file.is_file()
                && !is_truth(&file)
                && !is_hidden(&file)
                && (rig.is_some_and(|rig| rig.describes_file(&file))
                    || format_of(&file).is_ok_and(|format| format.holds_recording(&file)));
            if holds_recording {
                found.push(file);
            }
        }
        if found.is_empty() {
            return Err(DataError::file(path, "the folder holds no recording"));
        }
        found.sort();
        out.extend(found);
    }
    Ok(out)
}
