//! A table of commands over time.
//!
//! ```text
//! "PAMT"  version u32 = 1  rows u32  columns u32  step f64 (s)
//! rows × columns numbers, f32, row by row
//! ```
//!
//! The first row is at time zero. Between rows a value is read along a straight line; before the first
//! and after the last row that row holds.

use crate::{bytes, word};

/// First bytes of a table.
pub const MAGIC: &[u8; 4] = b"PAMT";
/// Version of the format.
pub const VERSION: u32 = 1;
/// Where the rows begin.
pub const ROWS_AT: usize = 24;

/// Columns of a plan's table.
pub const COLUMNS: [&str; 8] = [
    "displacement_mm",
    "velocity_mm_s",
    "stiffness_target_n_mm",
    "stiffness_n_mm",
    "mass_flexor_g",
    "mass_extensor_g",
    "pressure_flexor_kpa",
    "pressure_extensor_kpa",
];
/// Column of the flexor's pressure.
pub const PRESSURE_FLEXOR: usize = 6;
/// Column of the extensor's pressure.
pub const PRESSURE_EXTENSOR: usize = 7;

/// Errors in the bytes of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableError {
    /// They are no table.
    Magic,
    /// The format is another version's.
    Version,
    /// It has no rows or columns, or its step is not positive.
    Shape,
    /// The bytes end too early.
    Truncated,
}

impl core::fmt::Display for TableError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Magic => "these bytes are no table",
            Self::Version => "the table's format is another version's",
            Self::Shape => "the table has no rows or columns, or its step is not positive",
            Self::Truncated => "the table's bytes end too early",
        })
    }
}

impl core::error::Error for TableError {}

/// A table, read in place.
#[derive(Debug, Clone, Copy)]
pub struct Table<'a> {
    values: &'a [u8],
    rows: usize,
    columns: usize,
    step_s: f64,
}

impl<'a> Table<'a> {
    /// Checks the bytes.
    ///
    /// # Errors
    /// [`TableError`] if they are no table.
    pub fn new(from: &'a [u8]) -> Result<Self, TableError> {
        use TableError::{Magic, Shape, Truncated, Version};
        if from.get(..4) != Some(MAGIC) {
            return Err(Magic);
        }
        let number = |at| word(from, at).ok_or(Truncated);
        if number(4)? != VERSION as usize {
            return Err(Version);
        }
        let (rows, columns) = (number(8)?, number(12)?);
        let step_s = f64::from_le_bytes(bytes(from, 16).ok_or(Truncated)?);
        if rows == 0 || columns == 0 || !(step_s > 0.0 && step_s.is_finite()) {
            return Err(Shape);
        }
        let len = rows.checked_mul(columns).and_then(|n| n.checked_mul(4)).ok_or(Shape)?;
        let values = from.get(ROWS_AT..ROWS_AT.checked_add(len).ok_or(Shape)?).ok_or(Truncated)?;
        Ok(Self { values, rows, columns, step_s })
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Time between rows, s.
    #[must_use]
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// A number as it stands in the table.
    ///
    /// # Panics
    /// If there is no such row or column.
    #[must_use]
    pub fn cell(&self, row: usize, column: usize) -> f32 {
        assert!(row < self.rows && column < self.columns, "no such cell");
        let at = 4 * (row * self.columns + column);
        let mut number = [0; 4];
        number.copy_from_slice(&self.values[at..at + 4]);
        f32::from_le_bytes(number)
    }

    /// A column at a time (s).
    ///
    /// # Panics
    /// If there is no such column.
    #[must_use]
    pub fn value(&self, column: usize, time_s: f64) -> f32 {
        let place = (time_s / self.step_s).clamp(0.0, (self.rows - 1) as f64);
        let row = (place as usize).min(self.rows.saturating_sub(2));
        let share = (place - row as f64) as f32;
        let here = self.cell(row, column);
        if row + 1 < self.rows { here + share * (self.cell(row + 1, column) - here) } else { here }
    }

    /// Pressures of flexor and extensor at a time (s), kPa absolute, if the table is a plan's.
    #[must_use]
    pub fn pressures_kpa(&self, time_s: f64) -> Option<[f32; 2]> {
        (self.columns == COLUMNS.len())
            .then(|| [PRESSURE_FLEXOR, PRESSURE_EXTENSOR].map(|c| self.value(c, time_s)))
    }
}
