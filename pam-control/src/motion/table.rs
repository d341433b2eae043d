//! Motions from a CSV file.
//!
//! Columns are found by name: `time_s` and `displacement_mm` must be there; `velocity_mm_s` and
//! `acceleration_mm_s2` are taken from a natural cubic spline through the displacements where they are
//! not given; `stiffness_n_mm` and `force_n` (external load) are optional targets. Between rows the
//! spline, or straight lines through given columns, are read.

use super::{Motion, MotionPoint};
use crate::error::ControlError;
use pam_data::DataError;
use pam_data::formats::csv_columns::{column_names, read_columns};
use std::path::Path;

/// A motion that was read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionTable {
    times_s: Vec<f64>,
    displacements_mm: Vec<f64>,
    /// Second derivatives of the spline at the rows, mm/s².
    bends: Vec<f64>,
    velocities_mm_s: Option<Vec<f64>>,
    accelerations_mm_s2: Option<Vec<f64>>,
    stiffnesses_n_mm: Option<Vec<f64>>,
    forces_n: Option<Vec<f64>>,
}

impl MotionTable {
    /// Reads a file.
    ///
    /// # Errors
    /// [`ControlError::Data`] naming line and column of what is missing or no finite number.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, ControlError> {
        Self::read_at(path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn read_at(path: &Path) -> Result<Self, ControlError> {
        let names = column_names(path)?;
        let optional = |name: &str| -> Result<Option<Vec<f64>>, DataError> {
            if names.iter().any(|n| n == name) {
                let [_, values] = read_columns(path, ["time_s", name])?;
                Ok(Some(values))
            } else {
                Ok(None)
            }
        };
        let [times_s, displacements_mm] = read_columns(path, ["time_s", "displacement_mm"])?;
        if times_s.len() < 3 {
            let rows = times_s.len();
            let why = format!("{rows} rows make no motion: at least three are needed");
            return Err(DataError::file(path, why).into());
        }
        let bends = natural_spline(&times_s, &displacements_mm);
        Ok(Self {
            bends,
            velocities_mm_s: optional("velocity_mm_s")?,
            accelerations_mm_s2: optional("acceleration_mm_s2")?,
            stiffnesses_n_mm: optional("stiffness_n_mm")?,
            forces_n: optional("force_n")?,
            times_s,
            displacements_mm,
        })
    }

    /// Time between the first and the last row, s. The motion's time begins at zero at its first row.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.times_s[self.times_s.len() - 1] - self.times_s[0]
    }

    /// The stiffness column at a time, N/mm.
    #[must_use]
    pub fn stiffness_n_mm(&self, time_s: f64) -> Option<f64> {
        self.stiffnesses_n_mm.as_deref().map(|column| self.linear(column, time_s))
    }

    /// The load column at a time, N.
    #[must_use]
    pub fn force_n(&self, time_s: f64) -> Option<f64> {
        self.forces_n.as_deref().map(|column| self.linear(column, time_s))
    }

    /// The row before a time, and the share of the way to the next one.
    fn place(&self, time_s: f64) -> (usize, f64) {
        let t = &self.times_s;
        let time = (time_s + t[0]).clamp(t[0], t[t.len() - 1]);
        let row = t.partition_point(|&v| v <= time).clamp(1, t.len() - 1) - 1;
        (row, (time - t[row]) / (t[row + 1] - t[row]))
    }

    fn linear(&self, column: &[f64], time_s: f64) -> f64 {
        let (row, share) = self.place(time_s);
        column[row] + share * (column[row + 1] - column[row])
    }
}

impl Motion for MotionTable {
    fn at(&self, time_s: f64) -> MotionPoint {
        let (row, b) = self.place(time_s);
        let a = 1.0 - b;
        let step = self.times_s[row + 1] - self.times_s[row];
        let x = [self.displacements_mm[row], self.displacements_mm[row + 1]];
        let m = [self.bends[row], self.bends[row + 1]];
        let sixth = step * step / 6.0;
        let spline =
            a * x[0] + b * x[1] + sixth * ((a.powi(3) - a) * m[0] + (b.powi(3) - b) * m[1]);
        let slope = (x[1] - x[0]) / step
            + step / 6.0 * ((1.0 - 3.0 * a * a) * m[0] + (3.0 * b * b - 1.0) * m[1]);
        let given = |column: &Option<Vec<f64>>, otherwise: f64| {
            column.as_deref().map_or(otherwise, |c| self.linear(c, time_s))
        };
        MotionPoint {
            displacement_mm: spline,
            velocity_mm_s: given(&self.velocities_mm_s, slope),
            acceleration_mm_s2: given(&self.accelerations_mm_s2, a * m[0] + b * m[1]),
        }
    }
}

/// Second derivatives at the knots of the natural cubic spline, by elimination of its tridiagonal
/// system.
fn natural_spline(t: &[f64], x: &[f64]) -> Vec<f64> {
    let n = t.len();
    let (mut upper, mut value) = (vec![0.0; n], vec![0.0; n]);
    for i in 1..n - 1 {
        let (before, after) = (t[i] - t[i - 1], t[i + 1] - t[i]);
        let right = 6.0 * ((x[i + 1] - x[i]) / after - (x[i] - x[i - 1]) / before);
        let pivot = 2.0 * (before + after) - before * upper[i - 1];
        upper[i] = after / pivot;
        value[i] = (right - before * value[i - 1]) / pivot;
    }
    for i in (1..n - 1).rev() {
        value[i] -= upper[i] * value[i + 1];
    }
    value
}
