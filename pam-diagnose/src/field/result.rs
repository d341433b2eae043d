//! What a diagnosis of a field says.

use super::residual::OutputStory;
use crate::diagnosis::Verdict;
use crate::fit::Interval;
use serde::Serialize;

/// A named cause.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FieldCause {
    /// Name of the candidate.
    pub name: String,
    /// Its parameters with 95 % intervals.
    pub parameters: Vec<(&'static str, Interval)>,
    /// By how much minus two times the log-likelihood of the held-out rows rises without it, per row.
    pub held_drop: f64,
}

/// A set of candidates as it was judged.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RankedSet {
    /// Names.
    pub names: Vec<String>,
    /// Minus two times the log-likelihood of all rows, with the cost of its parameters.
    pub total: f64,
    /// Root-mean-square error of each output on the held-out rows.
    pub held_rmse: Vec<f64>,
}

/// A diagnosis of a field.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FieldDiagnosis {
    /// What may be said.
    pub verdict: Verdict,
    /// The causes, the most important first.
    pub causes: Vec<FieldCause>,
    /// What is wrong, output by output, before any name.
    pub residual: Vec<OutputStory>,
    /// The field's parameters with the causes in them.
    pub parameters: Vec<f64>,
    /// Root-mean-square error of each output on the held-out rows before and after.
    pub held_rmse: [Vec<f64>; 2],
    /// Every candidate alone, best first.
    pub singles: Vec<RankedSet>,
    /// Other sets of no more causes that explain nearly as much, best first.
    pub alternatives: Vec<RankedSet>,
}

impl FieldDiagnosis {
    /// The names of the causes.
    #[must_use]
    pub fn named(&self) -> Vec<&str> {
        self.causes.iter().map(|c| c.name.as_str()).collect()
    }
}
