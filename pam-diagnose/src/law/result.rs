//! A law as it is written.

use crate::fit::Interval;
use crate::rejection::{ParameterStability, StabilityTest};
use crate::test_set::ErrorReduction;
use crate::verdict::ChannelBand;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

/// A law that was found.
#[derive(Debug, Clone, Serialize)]
pub struct Law {
    /// What it adds and where, `force_n = c1_n_per_mm3 * x^3`.
    pub expression: String,
    /// The variables of the system that it depends on.
    pub variables: Vec<String>,
    /// Whether it remembers.
    pub remembers: bool,
    /// Candidates of the list that do what its terms do, if that is all of it: the law is a listed cause that was not named.
    pub listed: Vec<&'static str>,
    /// Its numbers with 95 % intervals.
    #[serde(serialize_with = "by_name")]
    pub parameters: Vec<(String, Interval)>,
    /// Named causes that stay beside it.
    pub beside: Vec<String>,
    /// Causes that were named before and in whose place it stands.
    pub replaces: Vec<Replaced>,
    /// Share of the squared error that the correction removes from the test set, which the law removes; of training and
    /// validation data without a test set. One if the correction removes nothing there.
    pub share_of_correction: f64,
    /// Share of the variation of the correction's values along the recordings that is the law's.
    pub similarity: f64,
    /// Errors on the test set with the named causes, and with the law.
    pub error_reduction: ErrorReduction,
    /// What it leaves of each channel of the test set.
    pub bands: Vec<ChannelBand>,
    /// The file that defines it as an effect.
    #[serde(rename = "definition")]
    pub file: String,
}

impl Law {
    /// What it is, as the subject of a sentence.
    #[must_use]
    pub fn subject(&self) -> String {
        if self.listed.is_empty() {
            return "an unlisted law".to_owned();
        }
        let names: Vec<String> =
            self.listed.iter().map(|id| pam_vocabulary::plain_name(id)).collect();
        format!("a law that equals the listed {}", names.join(" and "))
    }

    /// Whether every channel of the test set is within its noise.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        !self.bands.iter().any(|b| b.outside)
    }
}

fn by_name<S: Serializer>(parameters: &[(String, Interval)], to: S) -> Result<S::Ok, S::Error> {
    let mut map = to.serialize_map(Some(parameters.len()))?;
    for (name, interval) in parameters {
        map.serialize_entry(name, interval)?;
    }
    map.end()
}

/// Why a cause is not named in whose place a law stands.
pub(super) const TAKEN: &str = "a law takes its place";

/// A cause in whose place a law stands, fitted with one value that is there at all times.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Replaced {
    /// Id of the candidate.
    pub effect: String,
    /// Its value in parts of the recordings.
    pub stability: Option<ParameterStability>,
    /// Whether its value is the same at all times and in all recordings.
    pub stability_test: StabilityTest,
}

impl Replaced {
    /// Why it is not named.
    #[must_use]
    pub fn reason(&self) -> String {
        let changes = self.stability_test.sentence(&self.effect);
        if changes.is_empty() { TAKEN.to_owned() } else { format!("{changes}; {TAKEN}") }
    }
}

/// A law that was fitted to the training data.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RankedLaw {
    /// Its expression with its numbers.
    pub expression: String,
    /// Named causes beside it.
    pub beside: Vec<String>,
    /// Length of its description, nats.
    pub description_length: f64,
    /// Number of its parameters.
    pub parameters: usize,
    /// Normalised χ² of the validation data.
    pub validation: f64,
    /// Logarithm of its odds against the best one.
    pub log_odds: f64,
}
