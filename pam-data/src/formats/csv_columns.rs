//! CSV of the standard columns.
//!
//! ```text
//! # mass_flexor_g = 0.0315
//! # mass_extensor_g = 0.0315
//! # sealed_displacement_mm = 0.1
//! # sealed_pressure_flexor_kpa = 170.3
//! # sealed_pressure_extensor_kpa = 170.1
//! # rig = { muscles = { radius_mm = 8.0, length_mm = 150.0 } }
//! time_s,displacement_mm,velocity_mm_s,pressure_flexor_kpa,pressure_extensor_kpa,force_n
//! 0.000,0.1,0.0,170.2,169.9,-12.5
//! ```
//!
//! Header lines are optional: the air masses, the reading at rest after the valves were closed, and the [rig](RigFile) on
//! one line of TOML; other `# key = value` lines are kept as notes. Columns are found by
//! name. Data are taken as they are.

use super::columns::{self, Header, NAMES, NEEDED, RIG, VELOCITY};
use super::format::{FileFormat, Head, RecordingWriter};
use crate::atomic::write_atomic;
use crate::error::{DataError, read_bytes};
use crate::load_options::LoadOptions;
use crate::read_limit;
use crate::recording::Recording;
use crate::rig_file::RigFile;
use pam_core::SealedMasses;
use std::fmt::Write;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// The byte order mark that spreadsheets write before UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The format of CSV files of the standard columns.
#[derive(Debug)]
pub struct CsvColumns;

impl FileFormat for CsvColumns {
    fn id(&self) -> &'static str {
        "csv"
    }
    fn name(&self) -> &'static str {
        "a CSV file"
    }
    fn recognises(&self, head: &Head<'_>) -> bool {
        head.has_extension("csv") || head.names_standard_columns()
    }
    fn read_recordings(
        &self,
        path: &Path,
        options: &LoadOptions,
    ) -> Result<Vec<Recording>, DataError> {
        read_with(path, options)
    }
    fn recording_writer(&self) -> Option<(&'static str, RecordingWriter)> {
        Some(("csv", write))
    }
    fn rig(&self, path: &Path) -> Result<Option<RigFile>, DataError> {
        Ok(read_header(path, &header_of(path)?, &mut Recording::empty(path))?.rig)
    }
}

/// Reads a CSV file; gaps in time split it into several recordings.
///
/// # Errors
/// [`DataError`] with line and column for missing columns, cells that are no finite numbers, rows of
/// the wrong length, times that do not increase, masses that are not positive, and empty files.
pub fn read(path: &Path) -> Result<Vec<Recording>, DataError> {
    read_with(path, &LoadOptions::default())
}

/// [`read`] with the zero of the pressures and the rig that the options give.
///
/// # Errors
/// As [`read`].
pub fn read_with(path: &Path, options: &LoadOptions) -> Result<Vec<Recording>, DataError> {
    let bytes = read_bytes(path)?;
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&bytes);
    let mut recording = Recording::empty(path);
    let header = read_header(path, bytes, &mut recording)?;
    let names = names_of(path, bytes)?;
    let (values, velocity) = if names.iter().any(|n| n == VELOCITY) {
        let [time, x, v, pf, pe, force] = parse_columns(path, bytes, NAMES)?;
        ([time, x, pf, pe, force], Some(v))
    } else {
        (parse_columns(path, bytes, NEEDED)?, None)
    };
    columns::finish(recording, values, velocity, header, options)
}

/// Reads columns of any CSV file by their names; the first must increase from row to row.
///
/// # Errors
/// As [`read`], naming file, line and column.
pub fn read_columns<const N: usize>(
    path: &Path,
    wanted: [&str; N],
) -> Result<[Vec<f64>; N], DataError> {
    let bytes = read_bytes(path)?;
    parse_columns(path, bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&bytes), wanted)
}

/// The names of a CSV file's columns.
///
/// # Errors
/// [`DataError`] if the file cannot be read or its first line is no line of names.
pub fn column_names(path: &Path) -> Result<Vec<String>, DataError> {
    let bytes = read_bytes(path)?;
    names_of(path, bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&bytes))
}

fn names_of(path: &Path, bytes: &[u8]) -> Result<Vec<String>, DataError> {
    let mut reader =
        csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(bytes);
    let names = reader.headers().map_err(|e| csv_error(path, &e))?;
    Ok(names.iter().map(str::to_owned).collect())
}

fn parse_columns<const N: usize>(
    path: &Path,
    bytes: &[u8],
    wanted: [&str; N],
) -> Result<[Vec<f64>; N], DataError> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(bytes);
    let names = reader.headers().map_err(|e| csv_error(path, &e))?.clone();
    let header_line = reader.position().line().saturating_sub(1).max(1);
    if names.iter().all(str::is_empty) {
        return Err(DataError::file(path, "the file is empty: no line of column names"));
    }
    let found = wanted.map(|name| names.iter().position(|n| n == name));
    let missing: Vec<&str> =
        wanted.iter().zip(found).filter(|(_, place)| place.is_none()).map(|(n, _)| *n).collect();
    if !missing.is_empty() {
        let (column, be) = if missing.len() == 1 { ("column", "is") } else { ("columns", "are") };
        let message = format!(
            "{column} `{}` {be} missing; the columns here are [{}], needed are {}. Describe files of other columns, \
             units or separators in a rig file: `pam rig-file init {}` writes a first one",
            missing.join("`, `"),
            names.iter().collect::<Vec<_>>().join(", "),
            wanted.join(","),
            path.display()
        );
        return Err(DataError::line(path, header_line, message));
    }
    let places = found.map(Option::unwrap_or_default);

    let mut values = [const { Vec::new() }; N];
    let mut budget = read_limit::NumberBudget::new();
    let mut record = csv::ByteRecord::new();
    while reader.read_byte_record(&mut record).map_err(|e| csv_error(path, &e))? {
        // A record's own position lies before the comments that precede it, the reader's after its
        // line break, which the last line may lack.
        let line = record.position().map_or(1, csv::Position::line);
        let line = line.max(reader.position().line().saturating_sub(1));
        if record.len() != names.len() {
            return Err(DataError::line(
                path,
                line,
                format!(
                    "{} cells where the header names {}; the file may be truncated here",
                    record.len(),
                    names.len()
                ),
            ));
        }
        budget.take(path, line, N)?;
        for ((&place, name), column) in places.iter().zip(wanted).zip(&mut values) {
            let cell = std::str::from_utf8(&record[place]).unwrap_or("(not text)");
            let value: f64 = cell.parse().map_err(|_| {
                DataError::cell(path, line, name, format!("`{cell}` is not a number"))
            })?;
            if !value.is_finite() {
                return Err(DataError::cell(
                    path,
                    line,
                    name,
                    format!("{value} is not a finite number"),
                ));
            }
            column.push(value);
        }
        if let [.., before, now] = values[0][..]
            && now <= before
        {
            return Err(DataError::cell(
                path,
                line,
                wanted[0],
                format!("{now} s does not come after {before} s (a repeated frame?)"),
            ));
        }
    }
    if values[0].is_empty() {
        return Err(DataError::file(path, "no data rows: the file holds only a header"));
    }
    Ok(values)
}

fn csv_error(path: &Path, error: &csv::Error) -> DataError {
    match error.position() {
        Some(p) => DataError::line(path, p.line(), error.to_string()),
        None => DataError::file(path, error.to_string()),
    }
}

/// The lines above the column names; the rows below may be many and are not read.
fn header_of(path: &Path) -> Result<Vec<u8>, DataError> {
    let io = |e| DataError::io(path, e);
    let mut file = BufReader::new(read_limit::open(path)?);
    let mut header = Vec::new();
    loop {
        let start = header.len();
        file.read_until(b'\n', &mut header).map_err(io)?;
        if header.starts_with(BYTE_ORDER_MARK) {
            header.drain(..BYTE_ORDER_MARK.len());
        }
        if !header[start..].starts_with(b"#") {
            header.truncate(start);
            return Ok(header);
        }
    }
}

/// Reads the `# key = value` lines above the column names: masses, reading at rest, rig, and notes.
fn read_header(path: &Path, bytes: &[u8], recording: &mut Recording) -> Result<Header, DataError> {
    let mut header = Header::default();
    for (index, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let line = String::from_utf8_lossy(line);
        let Some(comment) = line.trim().strip_prefix('#') else { break };
        let Some((key, value)) = comment.split_once('=') else { continue };
        let (key, value) = (key.trim(), value.trim());
        let number = index as u64 + 1;
        let wrong = |message: String| DataError::cell(path, number, key, message);
        if key == RIG {
            header.rig = Some(RigFile::from_inline(value).map_err(wrong)?);
        } else if let Some(place) = Header::KEYS.iter().position(|k| *k == key) {
            let value = value.parse().map_err(|_| wrong(format!("`{value}` is not a number")))?;
            header.set(place, value).map_err(wrong)?;
        } else {
            recording.notes.push(format!("{key} = {value}"));
        }
    }
    Ok(header)
}

/// The CSV text of a recording, with masses in the header if `masses` is given.
#[must_use]
pub fn to_csv(recording: &Recording, masses: Option<SealedMasses>) -> String {
    let mut out = String::with_capacity(recording.len() * 90);
    for (key, value) in columns::numbers_of(recording, masses) {
        let _ = writeln!(out, "# {key} = {value}");
    }
    if let Some(rig) = &recording.rig {
        let _ = writeln!(out, "# {RIG} = {}", rig.to_inline());
    }
    out.push_str(&NAMES.join(","));
    out.push('\n');
    let columns = columns::of(recording);
    for i in 0..recording.len() {
        for (c, column) in columns.iter().enumerate() {
            let separator = if c == 0 { "" } else { "," };
            let _ = write!(out, "{separator}{}", column[i]);
        }
        out.push('\n');
    }
    out
}

/// Writes a recording as CSV; every number keeps all its digits.
///
/// # Errors
/// [`DataError::Io`].
pub fn write(path: &Path, recording: &Recording) -> Result<(), DataError> {
    write_atomic(path, to_csv(recording, recording.given_masses).as_bytes())
}
