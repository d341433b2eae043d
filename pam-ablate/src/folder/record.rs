//! The record of a finished cell.

use crate::error::AblateError;
use crate::experiment::{Measurements, Problem};
use crate::folder::{Planned, SweepFolder};
use pam_data::DataError;
use pam_data::atomic::write_atomic;
use pam_data::document;
use pam_data::read_limit::read_text;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

/// How a cell ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// With numbers.
    Done,
    /// It failed.
    Failed,
}

/// Quantities of a cell that tables show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Numbers that repeat.
    Metrics,
    /// Times, which do not.
    Times,
}

/// A cell that is over.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CellRecord {
    /// Name of the cell.
    pub id: String,
    /// Its seed.
    pub seed: u64,
    /// How it ended.
    pub status: Status,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Numbers that repeat; null where one is not finite.
    pub metrics: Map<String, Value>,
    /// Numbers that do not, s.
    pub times: Map<String, Value>,
    /// Notes for the reader.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Everything but the seed that decided the numbers.
    pub configuration: Value,
    /// Program, version and commit.
    pub made_by: String,
}

impl CellRecord {
    /// The record of a cell.
    #[must_use]
    pub fn of(planned: &Planned, result: Result<Measurements, Problem>, made_by: &str) -> Self {
        let (status, error, found) = match result {
            Ok(found) => (Status::Done, None, found),
            Err(problem) => (Status::Failed, Some(problem.message), Measurements::default()),
        };
        let map = |list: Vec<(String, f64)>| list.into_iter().map(|(k, v)| (k, json!(v))).collect();
        Self {
            id: planned.id.clone(),
            seed: planned.cell.seed,
            status,
            error,
            metrics: map(found.metrics),
            times: map(found.times),
            notes: found.notes,
            configuration: planned.configuration.clone(),
            made_by: made_by.to_owned(),
        }
    }

    fn values(&self, of: Quantity) -> &Map<String, Value> {
        match of {
            Quantity::Metrics => &self.metrics,
            Quantity::Times => &self.times,
        }
    }

    /// A metric or a time (s), if it was found.
    #[must_use]
    pub fn value(&self, of: Quantity, name: &str) -> Option<f64> {
        self.values(of).get(name).and_then(Value::as_f64)
    }

    /// Names of all metrics or times of some cells, in the order in which cells first have them.
    #[must_use]
    pub fn names(records: &[Option<Self>], of: Quantity) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for name in records.iter().flatten().flat_map(|r| r.values(of).keys()) {
            if !names.contains(name) {
                names.push(name.clone());
            }
        }
        names
    }
}

impl SweepFolder {
    /// Writes the record of a cell.
    ///
    /// # Errors
    /// [`AblateError::Data`] if it cannot be written.
    pub fn write_record(&self, record: &CellRecord) -> Result<(), AblateError> {
        let text = format!("{:#}\n", json!(record));
        Ok(write_atomic(self.cell(&record.id).join("result.json"), text.as_bytes())?)
    }

    /// The record of a cell that is over.
    ///
    /// # Errors
    /// [`AblateError`] if there is a file that cannot be read.
    pub fn read_record(&self, id: &str) -> Result<Option<CellRecord>, AblateError> {
        let path = self.cell(id).join("result.json");
        match read_text(&path) {
            Ok(text) => document::from_json(&text).map(Some).map_err(|e| {
                let message = format!("{e}; remove the cell's folder to have it run again");
                DataError::line(&path, e.line(&text), message).into()
            }),
            Err(e) if e.is_missing() => Ok(None),
            Err(e) => Err(e.into()),
        }
    }

    /// The records of cells, in their order; absent where a cell is not over.
    ///
    /// # Errors
    /// As [`read_record`](Self::read_record).
    pub fn records(&self, planned: &[Planned]) -> Result<Vec<Option<CellRecord>>, AblateError> {
        planned.iter().map(|p| self.read_record(&p.id)).collect()
    }
}
