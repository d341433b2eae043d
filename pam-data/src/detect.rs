//! Opens any supported file by its content.

use crate::error::DataError;
use crate::formats::mat_run::PressureReference;
use crate::formats::raw_log::RawLog;
use crate::formats::{columns, csv_columns, mat, mat_run, npz, npz_columns};
use crate::preprocess::{RawLogOptions, recordings_from_raw_log, refilter};
use crate::recording::Recording;
use std::fmt;
use std::io::Read;
use std::path::{Path, PathBuf};

/// What a file is, judged by its first bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// A raw log of the rig.
    RawLog,
    /// CSV of the standard columns.
    Csv,
    /// An `.npz` archive.
    Npz,
    /// A MATLAB level 5 file.
    Mat,
    /// Published weights.
    Eqx,
    /// A model of this framework.
    Safetensors,
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::RawLog => "a raw log",
            Self::Csv => "a CSV file",
            Self::Npz => "an .npz archive",
            Self::Mat => "a MATLAB file",
            Self::Eqx => "an .eqx weight file",
            Self::Safetensors => "a safetensors file",
        })
    }
}

impl FileKind {
    /// Judges a file.
    ///
    /// # Errors
    /// [`DataError`] if it cannot be read, is empty, or is none of the kinds.
    pub fn of(path: &Path) -> Result<Self, DataError> {
        let mut head = Vec::new();
        std::fs::File::open(path)
            .and_then(|f| f.take(65536).read_to_end(&mut head))
            .map_err(|e| DataError::io(path, e))?;
        if head.is_empty() {
            return Err(DataError::file(path, "the file is empty"));
        }
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        if head.starts_with(b"MATLAB") || head.starts_with(b"\x89HDF") || extension == "mat" {
            return Ok(Self::Mat);
        }
        if head.starts_with(b"\x93NUMPY") || extension == "eqx" {
            return Ok(Self::Eqx);
        }
        if head.starts_with(b"PK") || extension == "npz" {
            return Ok(Self::Npz);
        }
        if head.get(8) == Some(&b'{') || extension == "safetensors" {
            return Ok(Self::Safetensors);
        }
        // A raw log is known by its header and its columns of tabs, a CSV by commas between the names
        // of standard columns; prose with a comma is neither.
        let text = String::from_utf8_lossy(&head);
        let lines = || text.trim_start_matches('\u{feff}').lines();
        let comments = || lines().filter(|l| l.starts_with('#'));
        let first_row = lines().find(|l| !l.starts_with('#') && !l.trim().is_empty()).unwrap_or("");
        let names_columns = first_row.split(',').any(|cell| columns::NAMES.contains(&cell.trim()));
        if extension == "csv" || names_columns {
            return Ok(Self::Csv);
        }
        let names_frame = comments().any(|l| l.split_whitespace().any(|word| word == "frame"));
        if names_frame || (first_row.contains('\t') && comments().next().is_some()) {
            return Ok(Self::RawLog);
        }
        Err(DataError::file(
            path,
            "not a file this program knows: raw log, CSV, .npz, .mat, .eqx or .safetensors",
        ))
    }
}

impl FileKind {
    /// Whether a file of this kind holds a recording, by the names of its arrays where it could as
    /// well hold something else.
    #[must_use]
    pub fn holds_recording(self, path: &Path) -> bool {
        match self {
            Self::RawLog | Self::Csv => true,
            Self::Npz => npz::names(path).is_ok_and(|names| names.iter().any(|n| n == "time_s")),
            Self::Mat => mat::read(path).is_ok_and(|arrays| arrays.contains_key("dx")),
            Self::Eqx | Self::Safetensors => false,
        }
    }
}

/// How recordings are read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LoadOptions {
    /// Constants of the raw-log loader; its cutoff also serves `preprocess`.
    pub raw_log: RawLogOptions,
    /// Filter data that are no raw log like a raw log and take the velocity anew. Without it they are
    /// taken as they are.
    pub preprocess: bool,
    /// What zero means in a `.mat` run's pressures.
    pub pressure_reference: PressureReference,
}

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

/// Samples per second of a `.mat` run, whose file does not say.
const MAT_RATE_HZ: f64 = 1000.0;

/// Reads the recordings of one file: one, or several if it has gaps.
///
/// # Errors
/// [`DataError`] naming file, line and column.
pub fn open_recordings(path: &Path, options: &LoadOptions) -> Result<Vec<Recording>, DataError> {
    if is_truth(path) {
        return Err(DataError::file(
            path,
            "this is the sealed truth behind a made-up log; give the log itself",
        ));
    }
    let taken = match FileKind::of(path)? {
        FileKind::RawLog => {
            return recordings_from_raw_log(&RawLog::read(path)?, &options.raw_log);
        }
        FileKind::Csv => csv_columns::read(path)?,
        FileKind::Npz => npz_columns::read(path)?,
        FileKind::Mat => mat_run::read(path, options.pressure_reference, MAT_RATE_HZ)?,
        kind @ (FileKind::Eqx | FileKind::Safetensors) => {
            return Err(DataError::file(path, format!("a recording was expected, this is {kind}")));
        }
    };
    if !options.preprocess {
        return Ok(taken);
    }
    taken.into_iter().map(|r| refilter(r, options.raw_log.cutoff_hz)).collect()
}

/// Reads all recordings of some files and folders, as the commands do, one file after another.
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
    let mut recordings = Vec::new();
    for path in collect_paths(&paths)? {
        recordings.extend(open_recordings(&path, options)?);
    }
    Ok(recordings)
}

/// Expands folders into the recordings they hold (not recursively), sorted by name; files are kept
/// as given. Hidden files and files of other kinds inside a folder are passed over.
///
/// # Errors
/// [`DataError`] if a path cannot be read or a folder holds no recording.
pub fn collect_paths(paths: &[PathBuf]) -> Result<Vec<PathBuf>, DataError> {
    let mut out = Vec::new();
    for path in paths {
        if !path.is_dir() {
            out.push(path.clone());
            continue;
        }
        let io = |e: std::io::Error| DataError::io(path, e);
        let mut found = Vec::new();
        for entry in std::fs::read_dir(path).map_err(io)? {
            let file = entry.map_err(io)?.path();
            let holds_recording = file.is_file()
                && !is_truth(&file)
                && !is_hidden(&file)
                && FileKind::of(&file).is_ok_and(|kind| kind.holds_recording(&file));
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
