//! Text with a separator between numbers.

use crate::error::DataError;
use crate::read_limit::NumberBudget;
use crate::rig_file::FileLayout;
use std::path::{Path, PathBuf};

/// A table of text: lines of cells, with comments (`#`, `%`) and empty lines between them.
#[derive(Debug)]
pub struct DelimitedTable {
    path: PathBuf,
    names: Vec<String>,
    header_line: Option<u64>,
    separator: Separator,
    decimal_comma: bool,
    /// Lines with data: their numbers, counted from one, and their text.
    rows: Vec<(u64, String)>,
}

/// Separator of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Separator {
    Character(char),
    /// Any number of spaces or tabs.
    Space,
}

/// Lines that are looked at to find the separator.
const LOOKED_AT: usize = 20;

impl DelimitedTable {
    /// Reads the names of a table of text from memory; `path` is for messages.
    ///
    /// # Errors
    /// [`DataError`] if the bytes are no text or hold no rows, or the layout makes no sense.
    pub fn parse(path: &Path, bytes: Vec<u8>, layout: &FileLayout) -> Result<Self, DataError> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
        let text = std::str::from_utf8(bytes).map_or_else(
            // Spreadsheets of Western Europe write ° and µ in one byte.
            |_| bytes.iter().map(|&b| char::from(b)).collect::<String>(),
            str::to_owned,
        );
        if text.contains('\0') {
            return Err(DataError::file(path, "neither text nor a file of a known kind"));
        }
        // What a line takes beside its text.
        let lines = bytes.iter().filter(|&&b| b == b'\n').count();
        NumberBudget::new().take(path, 1, lines.saturating_mul(8))?;
        let mut rows: Vec<(u64, String)> = (1..)
            .zip(text.lines())
            .skip(layout.skip_lines)
            .filter(|(_, line)| {
                let line = line.trim_start();
                !line.is_empty() && !line.starts_with(['#', '%'])
            })
            .map(|(number, line)| (number, line.to_owned()))
            .collect();
        if rows.is_empty() {
            return Err(DataError::file(path, "the file holds no rows"));
        }
        let separator = match &layout.separator {
            Some(name) => Separator::named(name).map_err(|e| DataError::file(path, e))?,
            None => Separator::of(rows.iter().take(LOOKED_AT).map(|(_, line)| line.as_str())),
        };
        let decimal_comma = match layout.decimal.as_deref() {
            Some(",") => true,
            Some(".") => false,
            Some(other) => {
                return Err(DataError::file(
                    path,
                    format!("file.decimal is `{other}`; it is \".\" or \",\""),
                ));
            }
            None => has_decimal_commas(separator, &rows),
        };
        if decimal_comma && separator == Separator::Character(',') {
            return Err(DataError::file(
                path,
                "a comma cannot separate cells and be the decimal mark; set file.separator",
            ));
        }
        let first = separator.split(&rows[0].1);
        let is_header = layout
            .header
            .unwrap_or_else(|| first.iter().any(|cell| number(cell, decimal_comma).is_none()));
        let (names, header_line) = if is_header {
            let (line, _) = rows.remove(0);
            (first, Some(line))
        } else {
            ((1..=first.len()).map(|k| format!("column {k}")).collect(), None)
        };
        if rows.is_empty() {
            return Err(DataError::file(path, "no data rows: the file holds only a header"));
        }
        Ok(Self { path: path.to_owned(), names, header_line, separator, decimal_comma, rows })
    }

    /// Names of the columns.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The line that names the columns.
    #[must_use]
    pub fn header_line(&self) -> Option<u64> {
        self.header_line
    }

    /// The separator, as [`FileLayout::separator`] names it.
    #[must_use]
    pub fn separator_name(&self) -> String {
        match self.separator {
            Separator::Character('\t') => "tab".into(),
            Separator::Character(c) => c.to_string(),
            Separator::Space => "space".into(),
        }
    }

    /// The decimal mark, as [`FileLayout::decimal`] names it.
    #[must_use]
    pub fn decimal_name(&self) -> &'static str {
        if self.decimal_comma { "," } else { "." }
    }

    /// The line of a row.
    #[must_use]
    pub fn line_of_row(&self, row: usize) -> Option<u64> {
        self.rows.get(row).map(|(line, _)| *line)
    }

    /// The cells of the columns at these places as numbers.
    ///
    /// # Errors
    /// [`DataError`] naming line and column of the first cell that is no finite number, or a row with another number of
    /// cells than the header.
    pub fn columns(&self, places: &[usize]) -> Result<Vec<Vec<f64>>, DataError> {
        let mut budget = NumberBudget::new();
        budget.take(&self.path, 1, self.rows.len().saturating_mul(places.len()))?;
        let mut columns = vec![Vec::with_capacity(self.rows.len()); places.len()];
        for (line, text) in &self.rows {
            let cells = self.separator.split(text);
            if cells.len() != self.names.len() {
                return Err(DataError::line(
                    &self.path,
                    *line,
                    format!(
                        "{} cells where {} columns are; the file may be truncated here, or file.separator is \
                         not `{}`",
                        cells.len(),
                        self.names.len(),
                        self.separator_name()
                    ),
                ));
            }
            for (column, &place) in columns.iter_mut().zip(places) {
                let cell = &cells[place];
                let fail =
                    |message| DataError::cell(&self.path, *line, &self.names[place], message);
                let value = number(cell, self.decimal_comma)
                    .ok_or_else(|| fail(format!("`{cell}` is not a number")))?;
                if !value.is_finite() {
                    return Err(fail(format!("{value} is not a finite number")));
                }
                column.push(value);
            }
        }
        Ok(columns)
    }

    /// Which columns hold finite numbers alone: those that [`columns`](Self::columns) reads. One pass over the table.
    #[must_use]
    pub fn numeric(&self) -> Vec<bool> {
        let mut numeric = vec![true; self.names.len()];
        for (_, text) in &self.rows {
            let cells = self.separator.split(text);
            if cells.len() != numeric.len() {
                return vec![false; numeric.len()];
            }
            for (is, cell) in numeric.iter_mut().zip(&cells) {
                *is = *is && number(cell, self.decimal_comma).is_some_and(f64::is_finite);
            }
        }
        numeric
    }
}

impl Separator {
    fn named(name: &str) -> Result<Self, String> {
        let mut characters = name.chars();
        match (name, characters.next(), characters.next()) {
            ("tab", ..) => Ok(Self::Character('\t')),
            ("space", ..) => Ok(Self::Space),
            (_, Some(' '), None) => Ok(Self::Space),
            (_, Some(c), None) if !c.is_ascii_alphanumeric() && !"+-.\"".contains(c) => {
                Ok(Self::Character(c))
            }
            _ => Err(format!(
                "file.separator is `{name}`; it is one character such as \";\", \"tab\" or \"space\""
            )),
        }
    }

    /// The first of tab, semicolon, comma and spaces that splits all these lines into the same number of cells.
    fn of<'a>(lines: impl Iterator<Item = &'a str> + Clone) -> Self {
        let splits = |separator: &Self| {
            let mut counts = lines.clone().map(|line| separator.split(line).len());
            let first = counts.next().unwrap_or(0);
            first > 1 && counts.all(|count| count == first)
        };
        let all = [
            Self::Character('\t'),
            Self::Character(';'),
            Self::Character(','),
            Self::Character('|'),
            Self::Space,
        ];
        all.into_iter().find(splits).unwrap_or(Self::Character(','))
    }

    /// The cells of a line, without blanks and quotes around them.
    fn split(self, line: &str) -> Vec<String> {
        match self {
            Self::Space => line.split_whitespace().map(str::to_owned).collect(),
            Self::Character(c) if c.is_ascii() && line.contains('"') => {
                let mut reader = csv::ReaderBuilder::new()
                    .has_headers(false)
                    .delimiter(c as u8)
                    .trim(csv::Trim::All)
                    .from_reader(line.as_bytes());
                let mut record = csv::StringRecord::new();
                match reader.read_record(&mut record) {
                    Ok(true) => record.iter().map(str::to_owned).collect(),
                    _ => Vec::new(),
                }
            }
            Self::Character(c) => {
                let line = if c == '\t' { line.trim_end() } else { line };
                line.split(c).map(|cell| cell.trim().to_owned()).collect()
            }
        }
    }
}

/// True if cells are numbers with commas only.
fn has_decimal_commas(separator: Separator, rows: &[(u64, String)]) -> bool {
    if separator == Separator::Character(',') {
        return false;
    }
    let cells: Vec<String> =
        rows.iter().skip(1).take(LOOKED_AT).flat_map(|(_, line)| separator.split(line)).collect();
    let commas = cells.iter().filter(|c| number(c, false).is_none() && number(c, true).is_some());
    commas.count() > 0
}

/// The number in a cell.
fn number(cell: &str, decimal_comma: bool) -> Option<f64> {
    let cell = cell.trim();
    let looks_so = cell.starts_with(|c: char| c.is_ascii_digit() || "+-.,".contains(c))
        || cell.eq_ignore_ascii_case("nan")
        || cell.to_ascii_lowercase().contains("inf");
    if !looks_so {
        return None;
    }
    if decimal_comma { cell.replace(',', ".").parse().ok() } else { cell.parse().ok() }
}
