//! Protocol files: read, completed, checked.

use super::{CurrentSegment, PressureSegment, Protocol};
use crate::error::RigError;
use pam_data::{DataError, document, toml_file};
use serde::Deserialize;
use std::path::Path;
use toml::Spanned;

/// Longest run, s: a guard against a slip of the unit.
const LONGEST_S: f64 = 24.0 * 3600.0;

/// Line numbers of the parts of a file.
#[derive(Deserialize)]
struct Places {
    #[serde(default)]
    current: Vec<Spanned<toml::Value>>,
    #[serde(default)]
    pressure: Vec<Spanned<toml::Value>>,
}

impl Protocol {
    /// Reads a protocol file and the tables that it names.
    ///
    /// # Errors
    /// [`RigError`] naming file, line and field.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, RigError> {
        Self::read_at(path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn read_at(path: &Path) -> Result<Self, RigError> {
        Self::parse(&toml_file::text(path)?, path)
    }

    /// The protocol as a file that [`read`](Self::read) takes.
    ///
    /// # Panics
    /// Never: a protocol is plain tables.
    #[must_use]
    pub fn to_toml(&self) -> String {
        document::to_toml(self).expect("a protocol is plain tables")
    }

    /// Reads a protocol from text; `path` is for messages and the place of its tables.
    ///
    /// # Errors
    /// [`RigError`] naming file, line and field.
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Self, RigError> {
        Self::parse_at(text, path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn parse_at(text: &str, path: &Path) -> Result<Self, RigError> {
        let mut protocol: Self = toml_file::parse(text, path)?;
        let places: Places = toml_file::parse(text, path)?;
        let fail = |offset: usize, message: String| -> RigError {
            DataError::line(path, document::line_of(text, offset), message).into()
        };
        let folder = path.parent().unwrap_or(Path::new("."));
        for (i, (segment, place)) in protocol.current.iter_mut().zip(&places.current).enumerate() {
            if let CurrentSegment::Table(table) = segment {
                table.load(folder, ["time_s", "current_a"])?;
            }
            if let Some((field, why)) = segment.fault() {
                return Err(fail(place.span().start, format!("current[{i}].{field}: {why}")));
            }
        }
        for (i, (segment, place)) in protocol.pressure.iter_mut().zip(&places.pressure).enumerate()
        {
            if let PressureSegment::Table(table) = segment {
                let columns = ["time_s", "pressure_flexor_kpa", "pressure_extensor_kpa"];
                table.load(folder, columns)?;
            }
            if let Some((field, why)) = segment.fault() {
                return Err(fail(place.span().start, format!("pressure[{i}].{field}: {why}")));
            }
        }
        let at = |key: &str| text.find(key).unwrap_or(0);
        if let Some(conditions) = &protocol.conditions {
            conditions
                .check()
                .map_err(|why| fail(at("conditions"), format!("conditions: {why}")))?;
        }
        for (key, value) in
            [("inflate_s", protocol.lead_in.inflate_s), ("rest_s", protocol.lead_in.rest_s)]
        {
            if !(value.is_finite() && (0.0..=LONGEST_S).contains(&value)) {
                let why = format!("lead_in.{key}: {value} must be a number that is not negative");
                return Err(fail(at(key), why));
            }
        }
        let named = |text: &str| {
            !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c))
        };
        for (key, value) in [("name", Some(&protocol.name)), ("suffix", protocol.suffix.as_ref())] {
            if let Some(value) = value.filter(|v| !named(v)) {
                let why = format!("{key}: `{value}` names files; use letters, digits, - _ .");
                return Err(fail(at(key), why));
            }
        }
        let duration = protocol.duration_s();
        if !(duration > 0.0 && duration <= LONGEST_S) {
            let why = "nothing happens after time zero, or for more than a day: give [[current]] or \
                       [[pressure]] segments";
            return Err(fail(0, why.to_owned()));
        }
        protocol.runs().map_err(|e| match e {
            RigError::Protocol { message, .. } => fail(at("conditions"), message),
            other => other,
        })?;
        Ok(protocol)
    }
}
