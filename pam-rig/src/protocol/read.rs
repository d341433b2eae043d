//! Protocol files: read, completed, checked.

use super::{CurrentSegment, PressureSegment, Protocol};
use crate::error::RigError;
use crate::toml_file;
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
    pub fn read(path: &Path) -> Result<Self, RigError> {
        Self::parse(&toml_file::text(path)?, path)
    }

    /// The protocol as a file that [`read`](Self::read) takes.
    ///
    /// # Panics
    /// Never: a protocol is plain tables.
    #[must_use]
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a protocol is plain tables")
    }

    /// Reads a protocol from text; `path` is for messages and the place of its tables.
    ///
    /// # Errors
    /// [`RigError`] naming file, line and field.
    pub fn parse(text: &str, path: &Path) -> Result<Self, RigError> {
        let mut protocol: Self = toml_file::parse(text, path)?;
        let places: Places = toml_file::parse(text, path)?;
        let fail = |offset: usize, message: String| RigError::File {
            path: path.to_owned(),
            line: toml_file::line_of(text, offset),
            message,
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

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        Protocol::parse(text, Path::new("p.toml")).unwrap_err().to_string()
    }

    const SINE: &str = "[[current]]\nkind = \"sine\"\namplitude_a = 1.0\nfrequency_hz = 1.0\n";

    #[test]
    fn faults_are_told_with_their_line() {
        let head = "name = \"a\"\nconditions = [[30, 60]]\n";
        for (text, expected) in [
            (format!("{head}{SINE}duration_s = -1.0\n"), "p.toml:3: current[0].duration_s"),
            (format!("{head}{SINE}duration_s = nan\n"), "p.toml:3: current[0].duration_s"),
            (format!("{head}{SINE}"), "missing field `duration_s`"),
            (format!("{head}{SINE}duration_s = 1.0\nphase = 2\n"), "unknown field `phase`"),
            (format!("{head}[[current]]\nkind = \"square\"\n"), "unknown variant `square`"),
            (format!("{head}frequency = 1\n"), "p.toml:3: unknown field `frequency`"),
            (head.to_owned(), "p.toml:1: nothing happens"),
            (format!("name = \"a\"\n{SINE}duration_s = 1.0"), "neither conditions nor"),
            (
                format!("name = \"a/b\"\nconditions = \"grid\"\n{SINE}duration_s = 1.0"),
                "p.toml:1: name: `a/b`",
            ),
            (
                format!("name = \"a\"\nconditions = [[30, 99]]\n{SINE}duration_s = 1.0"),
                "p.toml:2: conditions: 99 is not a whole number",
            ),
            (
                format!("name = \"a\"\nconditions = [[30]]\n{SINE}duration_s = 1.0"),
                "[30.0] is not a pair",
            ),
            (
                format!("name = \"a\"\nconditions = [[30, 12.5]]\n{SINE}duration_s = 1.0"),
                "12.5 is not a whole",
            ),
            (
                format!("name = \"a\"\nconditions = \"all\"\n{SINE}duration_s = 1.0"),
                "`all` is neither train",
            ),
            (format!("name = \"a\"\nconditions = 3\n{SINE}duration_s = 1.0"), "expected \"train\""),
            ("name = \"a\nconditions".to_owned(), "p.toml:"),
        ] {
            let message = message(&text);
            assert!(message.contains(expected), "{text}\n-> {message}");
        }
    }

    #[test]
    fn pressures_beyond_room_and_supply_are_refused() {
        let text = "name = \"t\"\n\n[[pressure]]\nkind = \"sine\"\nmean_kpa = [150.0, 400.0]\n\
                    amplitude_kpa = [80.0, -80.0]\nfrequency_hz = 0.5\nduration_s = 4.0\n";
        assert!(message(text).contains("p.toml:3: pressure[0].amplitude_kpa: 70.0 kPa"));
    }

    #[test]
    fn a_table_is_read_from_beside_the_protocol() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.toml");
        let text = "name = \"mine\"\n[[pressure]]\nkind = \"table\"\nfile = \"commands.csv\"\n";
        std::fs::write(&path, text).unwrap();
        assert!(Protocol::read(&path).unwrap_err().to_string().contains("commands.csv"));
        let table =
            "time_s,pressure_extensor_kpa,pressure_flexor_kpa\n0,400,410\n1,420,390\n2,400,410\n";
        std::fs::write(folder.path().join("commands.csv"), table).unwrap();
        let protocol = Protocol::read(&path).unwrap();
        assert_eq!(protocol.duration_s(), 3.0);
        let psi = protocol.targets_psi(1.5).unwrap();
        assert!((psi[0] - (390.0 - 101.325) / 6.89476).abs() < 1e-9);
        std::fs::write(folder.path().join("commands.csv"), table.replace("\n1,", "\nx,")).unwrap();
        let message = Protocol::read(&path).unwrap_err().to_string();
        assert!(message.contains("commands.csv:3") && message.contains("time_s"), "{message}");
    }
}
