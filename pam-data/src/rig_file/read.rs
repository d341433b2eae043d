//! Files of a described rig as recordings.

use super::schema::{Column, ColumnKey, Columns, Filters, RigFile, Zero};
use super::units::{self, Quantity};
use crate::error::DataError;
use crate::formats::columns;
use crate::load_options::LoadOptions;
use crate::preprocess::{Cutoffs, derivative_of, filtered, low_passed};
use crate::recording::{Recording, SealedReading, StatedPressure, split_at_gaps};
use crate::table::Table;
use pam_core::SealedMasses;
use std::path::Path;
use std::sync::Arc;

/// Larger times are counted from the first sample: they are seconds since an epoch.
const EPOCH_S: f64 = 1e6;

/// One column that a recording needs.
struct Wanted<'a> {
    key: &'static str,
    quantity: Quantity,
    column: Column,
    what: &'a ColumnKey,
}

impl Columns {
    /// All columns that are named, in the order time, displacement, velocity, pressures, force.
    fn wanted(&self) -> Vec<Wanted<'_>> {
        let plain = |key, quantity, column: &'_ Column| (key, quantity, column.clone());
        let mut all = Vec::new();
        all.extend(self.time.as_ref().map(|c| (plain("time", Quantity::Time, c), &c.column)));
        let d = &self.displacement;
        all.push((plain("displacement", Quantity::Displacement, d), &d.column));
        all.extend(
            self.velocity.as_ref().map(|c| (plain("velocity", Quantity::Velocity, c), &c.column)),
        );
        for (key, p) in [
            ("pressure_flexor", &self.pressure_flexor),
            ("pressure_extensor", &self.pressure_extensor),
        ] {
            all.push(((key, Quantity::Pressure, p.as_column()), &p.column));
        }
        all.push((plain("force", Quantity::Force, &self.force), &self.force.column));
        all.into_iter()
            .map(|((key, quantity, column), what)| Wanted { key, quantity, column, what })
            .collect()
    }
}

impl RigFile {
    /// Checks units, signs and keys of the columns.
    pub(super) fn check_columns(&self) -> Result<(), String> {
        let Some(columns) = &self.columns else { return Ok(()) };
        if columns.time.is_none() && self.file.rate_hz.is_none() {
            return Err("without columns.time, file.rate_hz must be given".into());
        }
        let wanted = columns.wanted();
        for (k, w) in wanted.iter().enumerate() {
            let key = format!("columns.{}", w.key);
            let factor =
                self.factor(w.quantity, &w.column.unit).map_err(|e| format!("{key}: {e}"))?;
            let (sign, scale) = (w.column.sign, w.column.scale);
            if sign.abs() != 1.0 {
                return Err(format!("{key}.sign must be 1 or -1, got {sign}"));
            }
            if !(scale.is_finite() && scale != 0.0 && factor.is_finite()) {
                return Err(format!("{key}.scale must be a number other than 0, got {scale}"));
            }
            if w.quantity == Quantity::Time && (scale < 0.0 || sign < 0.0) {
                return Err(format!("{key} cannot run backwards"));
            }
            if *w.what == ColumnKey::Number(0) {
                return Err(format!("{key}.column is 0; columns are counted from one"));
            }
            if let Some(other) = wanted[..k].iter().find(|o| o.what == w.what) {
                return Err(format!(
                    "columns.{} and {key} are both {}; each quantity needs a column of its own",
                    other.key, w.what
                ));
            }
        }
        Ok(())
    }

    /// True if this file describes the columns of such a table: it names columns, and any of them is there.
    #[must_use]
    pub fn describes(&self, table: &Table) -> bool {
        let Some(columns) = &self.columns else { return false };
        columns.wanted().iter().any(|w| place(w.what, table.names()).is_some())
            || !columns::NAMES.iter().all(|n| table.names().iter().any(|name| name == n))
    }

    /// True if a file is a table that holds all columns of this rig.
    #[must_use]
    pub fn describes_file(&self, path: impl AsRef<Path>) -> bool {
        let path = path.as_ref();
        let Some(columns) = &self.columns else { return false };
        Table::open(path, &self.file).is_ok_and(|table| {
            columns.wanted().iter().all(|w| place(w.what, table.names()).is_some())
        })
    }

    /// Reads a file of this rig; gaps in time split it into several recordings.
    ///
    /// # Errors
    /// [`DataError`] naming all columns that are missing, the line and column of a cell that is no number, times that do
    /// not increase, or what makes no valid recording.
    pub fn recordings(
        &self,
        path: impl AsRef<Path>,
        options: &LoadOptions,
    ) -> Result<Vec<Recording>, DataError> {
        let path = path.as_ref();
        let table = Table::open(path, &self.file)?;
        self.recordings_of(&table, path, options)
    }

    pub(crate) fn recordings_of(
        &self,
        table: &Table,
        path: &Path,
        options: &LoadOptions,
    ) -> Result<Vec<Recording>, DataError> {
        let Some(columns) = &self.columns else {
            return Err(DataError::file(path, "the rig file names no columns"));
        };
        let wanted = columns.wanted();
        let places = places(&wanted, table, path)?;
        let mut values = table.columns(&places)?.into_iter().zip(&wanted).map(|(mut values, w)| {
            let c = &w.column;
            let factor = self
                .factor(w.quantity, &c.unit)
                .map_err(|e| DataError::file(path, format!("columns.{}: {e}", w.key)))?;
            for v in &mut values {
                *v = c.sign * (c.scale * *v + c.offset) * factor;
            }
            Ok((w.key, values))
        });
        let mut recording = Recording::empty(path);
        recording.notes.extend_from_slice(table.notes());
        recording.rig = Some(Arc::new(self.sizes()));
        let mut velocity = None;
        let mut time = None;
        for column in &mut values {
            let (key, values) = column?;
            match key {
                "time" => time = Some(values),
                "displacement" => recording.displacement_mm = values,
                "velocity" => velocity = Some(values),
                "pressure_flexor" => recording.pressure_flexor_kpa = values,
                "pressure_extensor" => recording.pressure_extensor_kpa = values,
                _ => recording.force_mn = values,
            }
        }
        recording.time_s = match time {
            Some(time) => self.times(time, table, path, &mut recording)?,
            None => {
                let rate = self.file.rate_hz.unwrap_or(1.0);
                (0..recording.displacement_mm.len()).map(|k| k as f64 / rate).collect()
            }
        };
        let stated = &columns.pressure_flexor;
        recording.pressure_in_file = units::find(Quantity::Pressure, &stated.unit)
            .map(|unit| StatedPressure {
                unit: unit.name,
                kpa: unit.factor,
                gauge: stated.reference == Zero::Gauge,
            })
            .filter(|stated| stated.gauge || stated.kpa != 1.0);
        let offset = |zero: Zero| if zero == Zero::Gauge { self.air.atmosphere_kpa } else { 0.0 };
        for (pressure, zero) in [
            (&mut recording.pressure_flexor_kpa, columns.pressure_flexor.reference),
            (&mut recording.pressure_extensor_kpa, columns.pressure_extensor.reference),
        ] {
            pressure.iter_mut().for_each(|p| *p += offset(zero));
        }
        self.complete(recording, velocity, options)
    }

    /// Times that increase, counted from the first sample where they are seconds since an epoch.
    fn times(
        &self,
        mut time: Vec<f64>,
        table: &Table,
        path: &Path,
        recording: &mut Recording,
    ) -> Result<Vec<f64>, DataError> {
        let back = time.windows(2).position(|w| w[1] <= w[0]);
        if let Some(i) = back {
            let message = format!(
                "time does not increase: {} s after {} s (a repeated sample?)",
                time[i + 1],
                time[i]
            );
            return Err(match table.line_of_row(i + 1) {
                Some(line) => DataError::line(path, line, message),
                None => DataError::file(path, format!("{message} at sample {}", i + 1)),
            });
        }
        if time[0].abs() > EPOCH_S {
            recording.notes.push(format!("time counted from the first sample, at {} s", time[0]));
            let start = time[0];
            time.iter_mut().for_each(|t| *t -= start);
        }
        Ok(time)
    }

    /// Masses, reading at rest, velocity and filters; then split at gaps.
    fn complete(
        &self,
        mut recording: Recording,
        velocity: Option<Vec<f64>>,
        options: &LoadOptions,
    ) -> Result<Vec<Recording>, DataError> {
        let derived = velocity.is_none();
        recording.velocity_mm_s = velocity.unwrap_or_else(|| vec![0.0; recording.len()]);
        recording.validate()?;
        self.add_air(&mut recording);
        let parts = split_at_gaps(recording, 2)?;
        parts.into_iter().map(|part| self.processed(part, derived, options)).collect()
    }

    /// The sealed masses and the reading at rest, where the recording has none of its own.
    pub(crate) fn add_air(&self, recording: &mut Recording) {
        let masses = self.air.mass_flexor_g.zip(self.air.mass_extensor_g);
        let masses = masses.map(|(flexor_g, extensor_g)| SealedMasses { flexor_g, extensor_g });
        recording.given_masses = recording.given_masses.or(masses);
        recording.sealed = recording.sealed.or_else(|| self.reading_at_rest(recording));
    }

    /// The channels behind their filters, through which they have gone already if `filter.in_file`.
    ///
    /// # Errors
    /// As [`filtered`].
    pub(crate) fn behind_filters(&self, part: Recording) -> Result<Recording, DataError> {
        let cutoffs = self.cutoffs();
        if self.filter.in_file { Ok(low_passed(part, &cutoffs)) } else { filtered(part, &cutoffs) }
    }

    pub(crate) fn cutoffs(&self) -> Cutoffs {
        let Filters { displacement_hz, pressure_hz, force_hz, .. } = self.filter;
        Cutoffs { displacement_hz, pressure_hz, force_hz }
    }

    /// The mean over the time at rest at the start.
    fn reading_at_rest(&self, r: &Recording) -> Option<SealedReading> {
        let end = r.time_s[0] + self.air.rest_s;
        let n = r.time_s.iter().take_while(|&&t| t < end).count();
        let mean = |v: &[f64]| v[..n].iter().sum::<f64>() / n as f64;
        (n > 0).then(|| SealedReading {
            displacement_mm: mean(&r.displacement_mm),
            pressure_flexor_kpa: mean(&r.pressure_flexor_kpa),
            pressure_extensor_kpa: mean(&r.pressure_extensor_kpa),
        })
    }

    /// The channels filtered, and the velocity derived, as the rig file says; `--preprocess` filters all alike.
    fn processed(
        &self,
        part: Recording,
        derived: bool,
        options: &LoadOptions,
    ) -> Result<Recording, DataError> {
        let Filters { velocity_hz, in_file, .. } = self.filter;
        let mut part = if options.preprocess && !in_file {
            filtered(part, &Cutoffs::all(options.raw_log.cutoff_hz))?
        } else {
            self.behind_filters(part)?
        };
        if derived || options.preprocess {
            part = derivative_of(part, (velocity_hz > 0.0).then_some(velocity_hz))?;
        }
        Ok(part)
    }
}

/// The place of a column, counted from zero.
fn place(key: &ColumnKey, names: &[String]) -> Option<usize> {
    match key {
        ColumnKey::Number(number) => number.checked_sub(1).filter(|p| *p < names.len()),
        ColumnKey::Name(name) => names
            .iter()
            .position(|n| n == name)
            .or_else(|| names.iter().position(|n| n.trim().eq_ignore_ascii_case(name.trim()))),
    }
}

/// The places of all columns, or an error that names all that are missing.
fn places(wanted: &[Wanted<'_>], table: &Table, path: &Path) -> Result<Vec<usize>, DataError> {
    let names = table.names();
    let found: Vec<Option<usize>> = wanted.iter().map(|w| place(w.what, names)).collect();
    let missing: Vec<String> = wanted
        .iter()
        .zip(&found)
        .filter(|(_, place)| place.is_none())
        .map(|(w, _)| format!("{} ({})", w.what, w.key))
        .collect();
    if missing.is_empty() {
        return Ok(found.into_iter().flatten().collect());
    }
    let message = format!(
        "the columns {} of the rig file are missing; the file has [{}]",
        missing.join(", "),
        names.join(", ")
    );
    Err(match table.header_line() {
        Some(line) => DataError::line(path, line, message),
        None => DataError::file(path, message),
    })
}
