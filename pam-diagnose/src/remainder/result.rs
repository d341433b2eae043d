//! The remainder as it is written.

use crate::law::{Law, Picture, RankedLaw};
use crate::test_set::ErrorReduction;
use serde::Serialize;
use std::fmt;

/// What became of the error that no listed cause explains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RemainderOutcome {
    /// The named causes leave nothing but noise.
    NothingLeft,
    /// No smooth correction is learned from the data, or the test set does not confirm it.
    NotLearned,
    /// A smooth correction is learned and confirmed, and no short law says the same.
    Correction,
    /// A law takes the place of the correction.
    Law,
}

impl fmt::Display for RemainderOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NothingLeft => "nothing_left",
            Self::NotLearned => "not_learned",
            Self::Correction => "correction",
            Self::Law => "law",
        })
    }
}

/// A model of the error that remains after the named causes.
#[derive(Debug, Clone, Serialize)]
pub struct Remainder {
    /// The outcome.
    pub outcome: RemainderOutcome,
    /// The outcome in a sentence.
    pub sentence: String,
    /// The correction, if one was learned.
    pub correction: Option<Correction>,
    /// The law, if one was found.
    pub law: Option<Law>,
    /// The laws that were fitted through the simulation, best first.
    pub ranking: Vec<RankedLaw>,
}

impl Remainder {
    /// Whether a law or a correction is a part of the extended model.
    #[must_use]
    pub fn is_part_of_model(&self) -> bool {
        matches!(self.outcome, RemainderOutcome::Law | RemainderOutcome::Correction)
    }

    /// Name and text of the file that defines what became part of the model.
    #[must_use]
    pub fn file(&self) -> Option<(&'static str, &str)> {
        match self.outcome {
            RemainderOutcome::Law => Some(("law.toml", &self.law.as_ref()?.file)),
            RemainderOutcome::Correction => {
                Some(("correction.toml", &self.correction.as_ref()?.file))
            }
            _ => None,
        }
    }

    /// A remainder without a correction.
    pub(crate) fn none(outcome: RemainderOutcome, sentence: &str) -> Self {
        let sentence = sentence.to_owned();
        Self { outcome, sentence, correction: None, law: None, ranking: Vec::new() }
    }
}

/// A smooth correction.
#[derive(Debug, Clone, Serialize)]
pub struct Correction {
    /// Where it acts.
    pub acts: Vec<String>,
    /// Its terms as expressions of a typical size of one, and their coefficients; the largest first.
    pub terms: Vec<(String, f64)>,
    /// Standard deviation of the prior of the coefficients, relative to the size of what acts there.
    pub prior_deviation: f64,
    /// Whether it depends on each group of variables; the most important first.
    pub depends_on: Vec<Dependence>,
    /// Share of the squared error of the validation data that it removes.
    pub validation_share: f64,
    /// The probability of that by chance, over blocks of time.
    pub p_value: f64,
    /// Errors on the test set with the named causes, and with the correction as well.
    pub error_reduction: ErrorReduction,
    /// Whether the test set proves that the error is smaller.
    pub confirmed: bool,
    /// The correction over its main variables, with the law.
    pub pictures: Vec<Picture>,
    /// The definitions with which the extended model holds it.
    #[serde(skip)]
    pub file: String,
}

/// Whether a correction depends on some variables.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Dependence {
    /// The variables, or `memory`.
    pub on: String,
    /// Root-mean-square error of data that were not fitted without any term of them, over that with all terms: 1 where they
    /// do not matter.
    pub error_ratio: f64,
    /// Its 95 % interval, over blocks of time.
    pub ci95: [f64; 2],
    /// The probability of so large a loss by chance.
    pub p_value: f64,
}
