//! Sweeps as data.
//!
//! A [`Sweep`] is a list of [`Axis`]es, each with values of one key or with named variants that set
//! several keys at once, and a list of seeds. Without a [`Search`] its cells are the grid of all values,
//! each with every seed; with one they are random draws, each with every seed.

mod builtin;
mod cells;
mod parse;

pub use cells::{Cell, Choice, MOST_CELLS};

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// One key and the value it is set to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Assignment {
    /// Path of the key: `model.activation`, `stage.2.epochs` (lists count from zero).
    pub key: String,
    /// The value.
    pub value: toml::Value,
    /// Line of the sweep file that says so; zero if none does.
    #[serde(skip)]
    pub line: u64,
}

impl Assignment {
    /// An assignment that no file says.
    #[must_use]
    pub fn new(key: &str, value: impl Into<toml::Value>) -> Self {
        Self { key: key.to_owned(), value: value.into(), line: 0 }
    }
}

/// One value of an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Variant {
    /// Its name in tables and figures.
    pub name: String,
    /// Assignments of the variant.
    pub set: Vec<Assignment>,
}

/// A range from which random search draws.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Range {
    /// Equally likely over `[low, high)`.
    Uniform(f64, f64),
    /// Its logarithm equally likely.
    LogUniform(f64, f64),
    /// A whole number from `low` to `high`, both included.
    Integers(i64, i64),
}

/// Values of an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Values {
    /// These; the first is what the others are compared with.
    List(Vec<Variant>),
    /// Draws from a range of one key's values.
    Range(String, Range),
}

/// One thing that is varied.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// Its name: a column of the results.
    pub name: String,
    /// Its values.
    pub values: Values,
    /// Line of the sweep file; zero if none.
    #[serde(skip)]
    pub line: u64,
}

/// Random search in place of a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Search {
    /// Number of draws; each is run with every seed.
    pub draws: usize,
    /// Seed of the draws.
    #[serde(default = "one")]
    pub seed: u64,
}

fn one() -> u64 {
    1
}

/// Which values of the first metric are better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// Larger ones.
    #[default]
    Max,
    /// Smaller ones.
    Min,
}

/// A sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// Its name.
    pub name: String,
    /// The question that the sweep answers, for the report.
    pub question: String,
    /// Seeds; every choice is run with each, and compared seed by seed.
    pub seeds: Vec<u64>,
    /// Metrics that the report shows, in this order; all if empty.
    pub metrics: Vec<String>,
    /// Which values of the first metric are better.
    pub goal: Goal,
    /// Settings of the experiment for all cells, in its own terms.
    pub experiment: toml::Table,
    /// Assignments in all cells, before the axes.
    pub set: Vec<Assignment>,
    /// The axes.
    pub axes: Vec<Axis>,
    /// Random search in place of the grid.
    pub search: Option<Search>,
    /// Folder that relative paths start from.
    pub base: PathBuf,
    /// Digests of the data behind the paths that the sweep names, where the experiment knows them
    /// ([`TrainingExperiment::digests`](crate::TrainingExperiment::digests)): what the data are, wherever they
    /// are.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub data: BTreeMap<String, String>,
    /// The sweep file, for messages; empty if none.
    #[serde(skip)]
    pub path: PathBuf,
    /// Line of `[experiment]`, for messages.
    #[serde(skip)]
    pub experiment_line: u64,
}

impl Sweep {
    /// A sweep without axes, with seed 1.
    #[must_use]
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            question: String::new(),
            seeds: vec![1],
            metrics: Vec::new(),
            goal: Goal::Max,
            experiment: toml::Table::new(),
            set: Vec::new(),
            axes: Vec::new(),
            search: None,
            base: PathBuf::new(),
            data: BTreeMap::new(),
            path: PathBuf::new(),
            experiment_line: 0,
        }
    }

    /// The sweep with another axis: a key and its values, the first being what the others are compared
    /// with.
    #[must_use]
    pub fn with_axis<V: Into<toml::Value>>(
        mut self,
        key: &str,
        values: impl IntoIterator<Item = V>,
    ) -> Self {
        let variant = |value: toml::Value| Variant {
            name: parse::label(&value),
            set: vec![Assignment::new(key, value)],
        };
        let values = Values::List(values.into_iter().map(|v| variant(v.into())).collect());
        self.axes.push(Axis { name: key.to_owned(), values, line: 0 });
        self
    }

    /// The sweep with these seeds.
    #[must_use]
    pub fn with_seeds(mut self, seeds: impl IntoIterator<Item = u64>) -> Self {
        self.seeds = seeds.into_iter().collect();
        self
    }

    /// True if two sweeps have the same cells and the same report, wherever they and their data are kept.
    /// Data are the same if their digests are; without digests, if their paths are.
    #[must_use]
    pub fn same_as(&self, other: &Self) -> bool {
        let known = !self.data.is_empty() && !other.data.is_empty();
        let digests = |s: &Self| {
            let mut digests: Vec<String> = s.data.values().cloned().collect();
            digests.sort();
            digests
        };
        let plain = |s: &Self| {
            let mut s = s.clone();
            s.base = PathBuf::new();
            s.data.clear();
            if known {
                s.experiment.remove("recordings");
            }
            serde_json::to_value(s).ok()
        };
        plain(self) == plain(other) && (!known || digests(self) == digests(other))
    }
}
