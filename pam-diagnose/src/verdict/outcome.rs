//! The verdicts, and the rule between them.

use crate::settings::VerdictSettings;
use serde::Serialize;
use std::fmt;

/// The outcome of a diagnosis.
///
/// ```
/// use pam_diagnose::settings::VerdictSettings;
/// use pam_diagnose::verdict::{Verdict, VerdictInput};
///
/// let confirmed = VerdictInput { causes: 1, confirmed: true, reduced: true, named_share: 0.9, ..VerdictInput::default() };
/// assert_eq!(Verdict::of(confirmed, &VerdictSettings::default()), Verdict::Explained);
/// let doubtful = VerdictInput { doubtful: true, ..confirmed };
/// assert_eq!(Verdict::of(doubtful, &VerdictSettings::default()).to_string(), "partly_explained");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The model predicts these recordings as well as noise (and its baseline discrepancy) allows.
    NothingFound,
    /// Each channel of the test data is within its noise with the named causes.
    Explained,
    /// The named causes stand, and a second error remains, a value is doubtful, or the test data do not test them.
    PartlyExplained,
    /// There is an error, and no listed cause explains it.
    Unexplained,
    /// A cause seems to be at work, but the test data do not confirm it.
    Unconfirmed,
    /// The model's own errors on baseline recordings are as large as those in the data.
    ModelInadequate,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NothingFound => "nothing_found",
            Self::Explained => "explained",
            Self::PartlyExplained => "partly_explained",
            Self::Unexplained => "unexplained",
            Self::Unconfirmed => "unconfirmed",
            Self::ModelInadequate => "model_inadequate",
        })
    }
}

/// The findings that decide a verdict.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VerdictInput {
    /// Number of causes that were named on training and validation data.
    pub causes: usize,
    /// Whether the test data confirm them: with fitted starts and masses, the whitened error is significantly smaller; with measured
    /// ones, the error is not significantly larger, or the fitted ones are about as likely with the causes as without.
    pub confirmed: bool,
    /// Whether training and validation data establish the causes, but the test set has too little power to confirm them.
    pub untested: bool,
    /// Whether the error of the simulation on the test data is proven to be smaller: the interval of the error reduction is
    /// above zero.
    pub reduced: bool,
    /// Share of the removable error that they remove.
    pub named_share: f64,
    /// Whether something is left that is no noise: a channel outside its band, or an anomaly.
    pub left: bool,
    /// Whether a value is at its limit, or differs between times or recordings.
    pub doubtful: bool,
    /// Whether the model's own errors on baseline recordings are as large as the errors in the data.
    pub inadequate: bool,
}

impl Verdict {
    /// The verdict:
    ///
    /// | causes | condition | verdict |
    /// |---|---|---|
    /// | 0 | the model's own errors are as large | model inadequate |
    /// | 0 | something is left that is no noise | unexplained |
    /// | 0 | otherwise | nothing found |
    /// | > 0 | the test data lack the power to confirm them, and the other data alone establish them | partly explained |
    /// | > 0 | the test data do not confirm them | unconfirmed |
    /// | > 0 | they remove less than `named_share` of the removable error, and something is left | unexplained |
    /// | > 0 | something is left that is no noise, a value is doubtful, or no error reduction is proven | partly explained |
    /// | > 0 | otherwise | explained |
    #[must_use]
    pub fn of(input: VerdictInput, settings: &VerdictSettings) -> Self {
        let e = input;
        match e.causes {
            0 if e.inadequate => Self::ModelInadequate,
            0 if e.left => Self::Unexplained,
            0 => Self::NothingFound,
            _ if e.untested && !e.confirmed => Self::PartlyExplained,
            _ if !e.confirmed => Self::Unconfirmed,
            _ if e.named_share < settings.named_share && e.left => Self::Unexplained,
            _ if e.left || e.doubtful || !e.reduced => Self::PartlyExplained,
            _ => Self::Explained,
        }
    }
}

/// Share of the removable error, from 0 to 1, that goes from one normalised χ² to another; `lowest` is the χ² to which
/// the error could be removed.
pub(crate) fn share(from: f64, to: f64, lowest: f64) -> f64 {
    ((from - to) / (from - lowest).max(1e-9)).clamp(0.0, 1.0)
}
