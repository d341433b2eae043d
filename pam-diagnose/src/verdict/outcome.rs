//! The four verdicts, and the rule between them.

use crate::settings::VerdictSettings;
use serde::Serialize;
use std::fmt;

/// The outcome of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The model predicts these recordings as well as noise (and its baseline discrepancy) allows.
    NothingFound,
    /// The named causes remove most of what can be removed.
    Explained,
    /// The named causes stand, but leave a good part of what can be removed.
    PartlyExplained,
    /// There is an error, and no listed cause explains it.
    Unexplained,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NothingFound => "nothing_found",
            Self::Explained => "explained",
            Self::PartlyExplained => "partly_explained",
            Self::Unexplained => "unexplained",
        })
    }
}

/// Normalised χ², 1 at the noise, of the base, of the named causes, and of the flexible model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChiSquares {
    /// Without any cause.
    pub base: f64,
    /// With the named causes.
    pub named: f64,
    /// With a flexible model without names.
    pub explainable: f64,
}

impl Verdict {
    /// The verdict on `causes` named causes:
    ///
    /// | causes | condition | verdict |
    /// |---|---|---|
    /// | 0 | χ² of the base below `something_chi_square` | nothing found |
    /// | 0 | otherwise | unexplained |
    /// | > 0 | share of the error above the noise below `named_share` | unexplained |
    /// | > 0 | shares of at least `explained_share` of the explainable and `explained_least_share` of all error | explained |
    /// | > 0 | otherwise | partly explained |
    #[must_use]
    pub fn of(chi: ChiSquares, causes: usize, settings: &VerdictSettings) -> Self {
        let ChiSquares { base, named, explainable } = chi;
        if causes == 0 {
            let nothing = base < settings.something_chi_square;
            return if nothing { Self::NothingFound } else { Self::Unexplained };
        }
        let share = |lowest: f64| (base - named) / (base - lowest).max(1e-9);
        let of_all = share(named.min(1.0));
        let of_explainable = share(explainable.max(1.0).min(base));
        if of_all < settings.named_share {
            Self::Unexplained
        } else if of_explainable >= settings.explained_share
            && of_all >= settings.explained_least_share
        {
            Self::Explained
        } else {
            Self::PartlyExplained
        }
    }
}

/// Share of the removable error, from 0 to 1, that goes from one normalised χ² to another; `lowest` is the χ² to which
/// the error could be removed.
pub(crate) fn share(from: f64, to: f64, lowest: f64) -> f64 {
    ((from - to) / (from - lowest).max(1e-9)).clamp(0.0, 1.0)
}
