use super::table::MotionTable;
use super::{Hold, MinimumJerk, Motion, Sine, Triangle};
use crate::error::ControlError;
use std::collections::BTreeMap;
use std::path::Path;

/// `kind:key=value,…` taken apart.
pub(super) struct Words<'a> {
    text: &'a str,
    pub(super) kind: &'a str,
    values: BTreeMap<&'a str, f64>,
}

impl<'a> Words<'a> {
    pub(super) fn parse(text: &'a str) -> Result<Self, ControlError> {
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        let mut values = BTreeMap::new();
        for part in rest.split(',').filter(|p| !p.trim().is_empty()) {
            let (key, value) = part
                .split_once('=')
                .ok_or_else(|| ControlError::spec(text, format!("`{part}` is not key=value")))?;
            let number: f64 = value.trim().parse().map_err(|_| {
                ControlError::spec(text, format!("`{}` is not a number", value.trim()))
            })?;
            if !number.is_finite() {
                return Err(ControlError::spec(text, format!("{} is not finite", key.trim())));
            }
            if values.insert(key.trim(), number).is_some() {
                return Err(ControlError::spec(text, format!("`{}` is given twice", key.trim())));
            }
        }
        Ok(Self { text, kind: kind.trim(), values })
    }

    pub(super) fn take(&mut self, key: &str) -> Result<f64, ControlError> {
        self.values
            .remove(key)
            .ok_or_else(|| ControlError::spec(self.text, format!("`{key}` is missing")))
    }

    pub(super) fn take_positive(&mut self, key: &str) -> Result<f64, ControlError> {
        let value = self.take(key)?;
        if value > 0.0 {
            Ok(value)
        } else {
            Err(ControlError::spec(self.text, format!("{key} must be positive")))
        }
    }

    pub(super) fn take_or(&mut self, key: &str, default: f64) -> f64 {
        self.values.remove(key).unwrap_or(default)
    }

    pub(super) fn finish(self) -> Result<(), ControlError> {
        match self.values.keys().next() {
            None => Ok(()),
            Some(key) => Err(ControlError::spec(
                self.text,
                format!("`{key}` is not a parameter of {}", self.kind),
            )),
        }
    }
}

/// A motion with its duration, as it was described.
pub struct MotionSpec {
    /// The motion.
    pub motion: Box<dyn Motion + Send + Sync>,
    /// How long it lasts, s.
    pub duration_s: f64,
    /// Its period, s, if it has one.
    pub period_s: Option<f64>,
    /// Further columns of the file it was read from, if it was.
    pub table: Option<MotionTable>,
}

impl std::fmt::Debug for MotionSpec {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MotionSpec").field("duration_s", &self.duration_s).finish_non_exhaustive()
    }
}

impl MotionSpec {
    /// Reads a motion from words or, if the text ends in `.csv`, from a file. Without `duration` a
    /// periodic motion lasts three periods, a reach half a second longer than it takes.
    ///
    /// # Errors
    /// [`ControlError`] saying what is wrong with the text, or file, line and column.
    pub fn parse(text: &str) -> Result<Self, ControlError> {
        if text.to_ascii_lowercase().ends_with(".csv") {
            let table = MotionTable::read(Path::new(text))?;
            let duration_s = table.duration_s();
            let motion = Box::new(table.clone());
            return Ok(Self { motion, duration_s, period_s: None, table: Some(table) });
        }
        let mut words = Words::parse(text)?;
        let (motion, default_s, period_s): (Box<dyn Motion + Send + Sync>, _, _) = match words.kind
        {
            kind @ ("sine" | "triangle") => {
                let amplitude_mm = words.take("A")?;
                let frequency_hz = words.take_positive("f")?;
                let centre_mm = words.take_or("x0", 0.0);
                let motion: Box<dyn Motion + Send + Sync> = if kind == "sine" {
                    Box::new(Sine { centre_mm, amplitude_mm, frequency_hz })
                } else {
                    Box::new(Triangle { centre_mm, amplitude_mm, frequency_hz })
                };
                (motion, 3.0 / frequency_hz, Some(1.0 / frequency_hz))
            }
            "minimum-jerk" => {
                let duration_s = words.take_positive("T")?;
                let delay_s = words.take_or("delay", 0.0);
                let (from_mm, to_mm) = (words.take("from")?, words.take("to")?);
                let motion = MinimumJerk { from_mm, to_mm, duration_s, delay_s };
                (Box::new(motion), delay_s + duration_s + 0.5, None)
            }
            "hold" => (Box::new(Hold { displacement_mm: words.take("x")? }), 1.0, None),
            _ => {
                return Err(ControlError::spec(
                    text,
                    "known are sine, triangle, minimum-jerk, hold, and files that end in .csv",
                ));
            }
        };
        let duration_s = words.take_or("duration", default_s);
        words.finish()?;
        if duration_s > 0.0 {
            Ok(Self { motion, duration_s, period_s, table: None })
        } else {
            Err(ControlError::spec(text, "duration must be positive"))
        }
    }
}
