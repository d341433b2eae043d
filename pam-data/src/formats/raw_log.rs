//! Raw logs of the rig.
//!
//! Lines that start with `#` are a header: date, memory, parameters such as `Fs = 1000 (Hz)`, and
//! last the column names. Data rows are separated by tabs: frame, x (encoder angle, deg), u (DAC),
//! current (A), p_res, pd1, pm1 (flexor, psi gauge), u1, pd2, pm2 (extensor, psi gauge), u2, sync.
//! Columns are found by their names, so further or reordered columns do no harm.

use super::format::{FileFormat, Head};
use crate::error::{DataError, read_bytes};
use crate::load_options::LoadOptions;
use crate::preprocess::recordings_from_raw_log;
use crate::read_limit::NumberBudget;
use crate::recording::Recording;
use std::path::{Path, PathBuf};

/// The format of raw logs.
#[derive(Debug)]
pub struct RawLogText;

impl RawLogText {
    /// Id of the format.
    pub const ID: &'static str = "raw_log";
}

impl FileFormat for RawLogText {
    fn id(&self) -> &'static str {
        Self::ID
    }
    fn name(&self) -> &'static str {
        "a raw log"
    }
    fn recognises(&self, head: &Head<'_>) -> bool {
        // The header names the columns; prose with a tab does not.
        let mut comments = head.lines().filter(|l| l.starts_with('#')).peekable();
        let tabs = head.first_row().contains('\t') && comments.peek().is_some();
        tabs || comments.any(|l| l.split_whitespace().any(|word| word == "frame"))
    }
    fn read_recordings(
        &self,
        path: &Path,
        options: &LoadOptions,
    ) -> Result<Vec<Recording>, DataError> {
        recordings_from_raw_log(&RawLog::read(path)?, &options.raw_log)
    }
    fn filters_channels(&self) -> bool {
        true
    }
}

/// Names of the columns that a recording needs.
const NEEDED: [&str; 6] = ["frame", "x", "u", "current", "pm1", "pm2"];

/// A raw log as it stands in its file.
#[derive(Debug, Clone)]
pub struct RawLog {
    /// The file.
    pub path: PathBuf,
    /// Header lines without their `#`.
    pub header: Vec<String>,
    /// Frames per second from the header, if it says so.
    pub frame_rate_hz: Option<f64>,
    /// Column names.
    pub names: Vec<String>,
    /// All columns, in the order of the names.
    pub columns: Vec<Vec<f64>>,
    /// Where the needed columns are.
    needed: [usize; 6],
}

impl RawLog {
    /// Reads a log.
    ///
    /// # Errors
    /// [`DataError`] with line and column if the file cannot be read, lacks a column, holds
    /// something that is no finite number, has rows of the wrong length (a truncated file), repeats
    /// a frame, or has no rows.
    pub fn read(path: &Path) -> Result<Self, DataError> {
        let bytes = read_bytes(path)?;
        Self::parse(path, &bytes)
    }

    /// Reads a log from memory; `path` is for messages and the name.
    ///
    /// # Errors
    /// As [`RawLog::read`].
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self, DataError> {
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let line = 1 + bytes[..e.valid_up_to()].iter().filter(|&&b| b == b'\n').count();
            DataError::line(path, line as u64, "not text (is this a raw log?)")
        })?;
        let mut header = Vec::new();
        let mut reader: Option<RowReader<'_>> = None;
        for (index, line) in text.lines().enumerate() {
            let number = index as u64 + 1;
            if let Some(comment) = line.strip_prefix('#') {
                header.push(comment.trim().to_owned());
            } else if !line.trim().is_empty() {
                if reader.is_none() {
                    reader = Some(RowReader::new(path, number, &header, bytes.len())?);
                }
                if let Some(reader) = &mut reader {
                    reader.row(number, line)?;
                }
            }
        }
        let Some(reader) = reader else {
            return Err(DataError::file(path, "no data rows: the file is empty or only a header"));
        };
        let frame_rate_hz = header.iter().find_map(|line| {
            let value = line.strip_prefix("Fs")?.trim_start().strip_prefix('=')?;
            value.split_whitespace().next()?.parse().ok()
        });
        Ok(Self {
            path: path.to_owned(),
            frame_rate_hz,
            header,
            names: reader.names,
            columns: reader.columns,
            needed: reader.needed,
        })
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.columns[0].len()
    }

    /// True if there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Frame counter.
    #[must_use]
    pub fn frame(&self) -> &[f64] {
        &self.columns[self.needed[0]]
    }

    /// Encoder angle, deg.
    #[must_use]
    pub fn angle_deg(&self) -> &[f64] {
        &self.columns[self.needed[1]]
    }

    /// Command of the motor, DAC counts.
    #[must_use]
    pub fn command(&self) -> &[f64] {
        &self.columns[self.needed[2]]
    }

    /// Motor current, A.
    #[must_use]
    pub fn current_a(&self) -> &[f64] {
        &self.columns[self.needed[3]]
    }

    /// Flexor pressure, psi gauge.
    #[must_use]
    pub fn pressure_flexor_psi(&self) -> &[f64] {
        &self.columns[self.needed[4]]
    }

    /// Extensor pressure, psi gauge.
    #[must_use]
    pub fn pressure_extensor_psi(&self) -> &[f64] {
        &self.columns[self.needed[5]]
    }
}

/// Reads data rows into columns.
struct RowReader<'a> {
    path: &'a Path,
    names: Vec<String>,
    needed: [usize; 6],
    columns: Vec<Vec<f64>>,
    budget: NumberBudget,
}

impl<'a> RowReader<'a> {
    fn new(path: &'a Path, line: u64, header: &[String], bytes: usize) -> Result<Self, DataError> {
        // The names are the last header line, or the last that has a frame counter if more follows.
        let names: Vec<String> = header
            .iter()
            .rev()
            .find(|line| line.split_whitespace().any(|name| name == NEEDED[0]))
            .or(header.last())
            .map(|names| names.split_whitespace().map(str::to_owned).collect())
            .unwrap_or_default();
        let mut needed = [0; 6];
        for (place, name) in needed.iter_mut().zip(NEEDED) {
            *place = names.iter().position(|n| n == name).ok_or_else(|| {
                DataError::line(
                    path,
                    line.saturating_sub(1).max(1),
                    format!(
                        "the header names the columns [{}], `{name}` is missing; a raw log needs {}",
                        names.join(", "),
                        NEEDED.join(", ")
                    ),
                )
            })?;
        }
        // A cell takes five bytes or more, most of the time.
        let rows = bytes / (5 * names.len());
        let columns = vec![Vec::with_capacity(rows); names.len()];
        Ok(Self { path, names, needed, columns, budget: NumberBudget::new() })
    }

    fn row(&mut self, number: u64, line: &str) -> Result<(), DataError> {
        self.budget.take(self.path, number, self.names.len())?;
        let mut count = 0;
        for cell in line.split_ascii_whitespace() {
            let Some(column) = self.columns.get_mut(count) else {
                return Err(DataError::line(
                    self.path,
                    number,
                    format!("more than the {} cells that the header names", self.names.len()),
                ));
            };
            match cell.parse::<f64>() {
                Ok(value) if value.is_finite() => column.push(value),
                Ok(value) => {
                    return Err(DataError::cell(
                        self.path,
                        number,
                        &self.names[count],
                        format!("{value} is not a finite number"),
                    ));
                }
                Err(_) => {
                    return Err(DataError::cell(
                        self.path,
                        number,
                        &self.names[count],
                        format!("`{cell}` is not a number"),
                    ));
                }
            }
            count += 1;
        }
        if count != self.names.len() {
            return Err(DataError::line(
                self.path,
                number,
                format!(
                    "{count} cells where the header names {}; the file may be truncated here",
                    self.names.len()
                ),
            ));
        }
        let frames = &self.columns[self.needed[0]];
        if let [.., before, now] = frames[..]
            && now <= before
        {
            let what = if now == before { "repeats" } else { "goes back from" };
            return Err(DataError::cell(
                self.path,
                number,
                "frame",
                format!("frame {now} {what} frame {before}; frames must increase"),
            ));
        }
        Ok(())
    }
}

/// One row of a log that a program makes; see the module for the units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Row {
    /// Encoder angle, deg.
    pub angle_deg: f64,
    /// Command of the motor, DAC counts.
    pub command: f64,
    /// Motor current, A.
    pub current_a: f64,
    /// Pressure of the reservoir, psi gauge.
    pub reservoir_psi: f64,
    /// Commanded pressures of flexor and extensor, psi gauge.
    pub commanded_psi: [f64; 2],
    /// Measured pressures of flexor and extensor, psi gauge.
    pub measured_psi: [f64; 2],
    /// State of the valves of flexor and extensor: −1 shut, 1 inflating, 2 exhausting.
    pub valves: [i8; 2],
    /// True if the controller runs.
    pub sync: bool,
}

/// The text of a raw log with consecutive frames from `first_frame` at `rate_hz`. `note` becomes
/// the first header line.
#[must_use]
pub fn to_text(note: &str, rate_hz: f64, first_frame: u64, rows: &[Row]) -> String {
    use std::fmt::Write;
    let mut out = String::with_capacity(rows.len() * 96);
    let _ = write!(
        out,
        "#{note}\n#\n#Parameters:\n#\tFs = {rate_hz} (Hz)\n#\n\
         # frame\tx\tu\tcurrent\tp_res\tpd1\tpm1\tu1\tpd2\tpm2\tu2\tsync\t\n"
    );
    for (frame, r) in (first_frame..).zip(rows) {
        let _ = writeln!(
            out,
            "{frame}\t{:.6}\t{:.6}\t{:.6}\t{:.6}\t{:.6}\t{:.6}\t{}\t{:.6}\t{:.6}\t{}\t{}\t",
            r.angle_deg,
            r.command,
            r.current_a,
            r.reservoir_psi,
            r.commanded_psi[0],
            r.measured_psi[0],
            r.valves[0],
            r.commanded_psi[1],
            r.measured_psi[1],
            r.valves[1],
            u8::from(r.sync)
        );
    }
    out
}
