//! The study: cells, run one after the other.

use super::cells::Cells;
use super::measure::processor;
use super::result::{Row, StudyResult};
use pam_core::ModelError;
use std::time::{Duration, Instant};

/// Cells to be run, and which of them.
pub struct Study {
    cells: Vec<Box<dyn Cells>>,
    /// Names of the problems to run; all if empty.
    problems: Vec<String>,
    /// Names of the methods to run; all if empty.
    methods: Vec<String>,
    /// Most repeats of a timing.
    repeat: usize,
    quick: bool,
}

/// How far a study has come.
#[derive(Debug, Clone, Copy)]
pub struct Progress<'a> {
    /// Rows so far.
    pub done: usize,
    /// Rows in all.
    pub total: usize,
    /// Time so far.
    pub elapsed: Duration,
    /// Time left, if the rest is like what was done; cells differ.
    pub left: Duration,
    /// The last row.
    pub row: &'a Row,
}

impl Default for Study {
    fn default() -> Self {
        Self::new()
    }
}

impl Study {
    /// A study without cells, each timed five times.
    #[must_use]
    pub fn new() -> Self {
        Self {
            cells: Vec::new(),
            problems: Vec::new(),
            methods: Vec::new(),
            repeat: 5,
            quick: false,
        }
    }

    /// The study with further cells.
    #[must_use]
    pub fn with(mut self, cells: impl Cells + 'static) -> Self {
        self.cells.push(Box::new(cells));
        self
    }

    /// The study with another number of repeats of a timing, at least one.
    #[must_use]
    pub fn with_repeat(mut self, repeat: usize) -> Self {
        self.repeat = repeat.max(1);
        self
    }

    /// Says in the result that this is the short form.
    #[must_use]
    pub fn marked_quick(mut self) -> Self {
        self.quick = true;
        self
    }

    /// The study of these problems only; of all if there are none.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`] with the problems that there are.
    pub fn with_problems(mut self, problems: &[String]) -> Result<Self, ModelError> {
        check("problem", problems, &self.problem_names())?;
        self.problems = problems.to_vec();
        Ok(self)
    }

    /// The study of these methods only; of all if there are none.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`] with the methods that there are.
    pub fn with_methods(mut self, methods: &[String]) -> Result<Self, ModelError> {
        check("gradient method", methods, &self.method_names())?;
        self.methods = methods.to_vec();
        Ok(self)
    }

    /// The names of the problems.
    #[must_use]
    pub fn problem_names(&self) -> Vec<String> {
        unique(self.names().map(|(problem, _)| problem))
    }

    /// The names of the methods.
    #[must_use]
    pub fn method_names(&self) -> Vec<String> {
        unique(self.names().map(|(_, method)| method))
    }

    /// Number of rows that the study will have.
    #[must_use]
    pub fn len(&self) -> usize {
        self.names().filter(|(problem, method)| self.wants(problem, method)).count()
    }

    /// Whether nothing is to be run.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Runs the cells one after the other, each on one thread so that times can be compared; `progress`
    /// is told of every row. A cell that fails makes a row that says why.
    pub fn run(&self, mut progress: impl FnMut(Progress<'_>)) -> StudyResult {
        let total = self.len();
        let clock = Instant::now();
        let mut rows: Vec<Row> = Vec::with_capacity(total);
        for cells in &self.cells {
            let wants = |problem: &str, method: &str| self.wants(problem, method);
            cells.run(self.repeat, &wants, &mut |row| {
                let done = rows.len() + 1;
                let elapsed = clock.elapsed();
                let left = elapsed.mul_f64(total.saturating_sub(done) as f64 / done as f64);
                progress(Progress { done, total, elapsed, left, row: &row });
                rows.push(row);
            });
        }
        StudyResult { quick: self.quick, repeat: self.repeat, processor: processor(), rows }
    }

    fn names(&self) -> impl Iterator<Item = (String, String)> {
        self.cells.iter().flat_map(|cells| cells.names())
    }

    fn wants(&self, problem: &str, method: &str) -> bool {
        let in_list =
            |list: &[String], name: &str| list.is_empty() || list.iter().any(|n| n == name);
        in_list(&self.problems, problem) && in_list(&self.methods, method)
    }
}

fn check(kind: &'static str, names: &[String], known: &[String]) -> Result<(), ModelError> {
    match names.iter().find(|name| !known.contains(name)) {
        None => Ok(()),
        Some(name) => {
            Err(ModelError::UnknownName { kind, name: name.clone(), known: known.join(", ") })
        }
    }
}

/// The different names in the order of their first appearance.
fn unique(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for name in names {
        if !out.contains(&name) {
            out.push(name);
        }
    }
    out
}
