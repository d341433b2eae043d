//! The experiment of a cell.
//!
//! An [`Experiment`] turns a [`Cell`] into numbers. The one that comes with the crate trains models
//! ([`TrainingExperiment`](crate::TrainingExperiment)); a program sweeps one of its own by implementing
//! the trait.

use crate::sweep::Cell;
use serde_json::Value;
use std::fmt;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Numbers that a cell found, in the order in which tables show them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measurements {
    /// Numbers that the configuration, the seed and the data decide: the same bits every time. One that
    /// is not finite counts as missing.
    pub metrics: Vec<(String, f64)>,
    /// Times in seconds, and whatever else is different every time.
    pub times: Vec<(String, f64)>,
    /// Notes for the reader.
    pub notes: Vec<String>,
}

/// How a cell ended, if it did not fail.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// With numbers.
    Finished(Measurements),
    /// It was asked to stop, and goes on from its folder next time.
    Stopped,
}

/// Why a configuration or a cell is no good.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Which of the cell's assignments is to blame, if one is.
    pub assignment: Option<usize>,
    /// The problem and its remedy.
    pub message: String,
}

impl Problem {
    /// A problem that no single assignment is to blame for.
    #[must_use]
    pub fn new(message: impl Into<String>) -> Self {
        Self { assignment: None, message: message.into() }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Problem {}

impl From<String> for Problem {
    fn from(message: String) -> Self {
        Self::new(message)
    }
}

/// Where a cell works, and what it is to look at while it does.
pub struct Workplace<'a> {
    /// A folder of its own, in which it finds what it left there when it was stopped or killed.
    pub folder: &'a Path,
    /// Set when the cell should save its state and return [`Outcome::Stopped`].
    pub stop: &'a AtomicBool,
    /// Called with the share that is done, 0 to 1.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

impl fmt::Debug for Workplace<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Workplace").field("folder", &self.folder).finish_non_exhaustive()
    }
}

/// The work of a cell. Cells run concurrently, each in a pool of threads of its own.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no experiment of a sweep",
    note = "implement `Experiment`: `configuration` and `run`; `TrainingExperiment` trains a model in each cell"
)]
pub trait Experiment: Sync {
    /// Everything but the seed that decides the numbers of a cell. Cells with equal configuration and
    /// seed are the same cell. It is asked for all cells before the first one runs, and should find what
    /// is wrong then.
    ///
    /// # Errors
    /// [`Problem`] naming the assignment that makes no sense.
    fn configuration(&self, cell: &Cell) -> Result<Value, Problem>;

    /// Runs a cell, or goes on with it from what it left in its folder. A panic counts as a failure.
    ///
    /// # Errors
    /// [`Problem`]: the cell has failed, which is recorded and ends nothing but the cell.
    fn run(&self, cell: &Cell, at: &Workplace<'_>) -> Result<Outcome, Problem>;
}
