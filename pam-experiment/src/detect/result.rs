//! The result of [`detect`](super::detect()); `detect.json`.

use super::trials::TriedLimit;
use serde::{Deserialize, Serialize};

/// A magnitude with what it stands for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// The value of the effect's parameter.
    pub value: f64,
    /// The magnitude along the effect's way: its parameter beyond absent, or the reciprocal of a falling one.
    #[serde(default, skip_serializing)]
    pub magnitude: f64,
    /// The noncentrality there.
    pub noncentrality: f64,
}

/// The limits of one effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Id of the effect.
    pub effect: String,
    /// The id, with the chamber where each has limits of its own.
    pub label: String,
    /// Parameter that tells the magnitude, with its unit.
    pub parameter: String,
    /// Scales and switches that are kept.
    pub kept: Vec<(String, f64)>,
    /// Fitted parameters: degrees of freedom.
    pub parameters: usize,
    /// The least that any test with this familywise error rate finds; absent if the effect is not seen within its range.
    pub familywise: Option<Limit>,
    /// From here on a diagnosis lists the effect, if only as a minor cause.
    pub listed: Option<Limit>,
    /// From here on a diagnosis names it as a cause: by trials where they were made, else as foretold.
    pub named: Option<Limit>,
    /// From here on a diagnosis should name it by the noncentrality that its rules require.
    pub foretold: Option<Limit>,
    /// Trials at chosen magnitudes; absent where none were made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tried: Option<TriedLimit>,
}

impl Limits {
    /// The limit of a named cause over the one of any test.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        self.named.map(|l| l.value)
    }
}

/// How well an effect can be told from another one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// Label of the effect that is at work.
    pub effect: String,
    /// Id of the one that may be taken for it.
    pub other: String,
    /// Cosine between its signature and the span of the other's.
    pub cosine: f64,
    /// The magnitude, in multiples of the limit of a named cause, from which on a diagnosis distinguishes the two; absent if
    /// none does.
    pub distinguished_from: Option<f64>,
    /// In how many trials at the limit or beyond in which the effect was named the other one was named as well or not distinguished,
    /// and the number of such trials; absent without any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tried: Option<[usize; 2]>,
}

impl Pair {
    /// Whether a diagnosis confuses the two at `multiples` of the limit: by at least half of the trials, or as predicted where none were
    /// made.
    #[must_use]
    pub fn is_confused(&self, multiples: f64) -> bool {
        match self.tried {
            Some([confused, all]) => 2 * confused >= all,
            None => self.distinguished_from.is_none_or(|from| from > multiples),
        }
    }
}

/// Detection limits and the matrix of confusions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Detection {
    /// Names and lengths (s) of the recordings.
    pub recordings: Vec<(String, f64)>,
    /// Standard deviations of the noise of x (mm), P_f and P_e (kPa), in means over a row.
    pub noise: Vec<f64>,
    /// Rows that train and validate.
    pub rows: usize,
    /// Power of the limits.
    pub power: f64,
    /// Familywise rate of false alarms.
    pub level: f64,
    /// Limits, effect by effect.
    pub limits: Vec<Limits>,
    /// Every effect beside every other one.
    pub pairs: Vec<Pair>,
}

impl Detection {
    /// The limits of an effect by its label.
    #[must_use]
    pub fn of(&self, label: &str) -> Option<&Limits> {
        self.limits.iter().find(|l| l.label == label)
    }

    /// Labels and ids that a diagnosis would not distinguish at `multiples` of the limit.
    #[must_use]
    pub fn confused(&self, multiples: f64) -> Vec<(&str, &str)> {
        self.pairs
            .iter()
            .filter(|p| p.is_confused(multiples))
            .map(|p| (p.effect.as_str(), p.other.as_str()))
            .collect()
    }
}
