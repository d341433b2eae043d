//! What may be said in the end.

use serde::Serialize;
use std::fmt;

/// The outcome of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The model predicts these recordings as well as noise (and what is ordinary for it) allows.
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

/// Share of the explainable error that names must remove to explain it.
const EXPLAINED: f64 = 0.8;
/// Share of all error above the floors that they must remove besides.
const LEAST: f64 = 0.5;
/// Below this share no name is given.
const NAMED: f64 = 0.25;
/// Mean squared error over the floors', at which there is something to explain.
const SOMETHING: f64 = 2.5;

/// What the levels (squared errors in units of the floors, three for a residual at the floors) say.
/// `explainable` is the level that a flexible reference reaches.
pub(crate) fn weigh(base: f64, named: f64, explainable: f64, causes: usize) -> Verdict {
    if causes == 0 {
        return if base < 3.0 * SOMETHING { Verdict::NothingFound } else { Verdict::Unexplained };
    }
    let lowest = named.min(3.0);
    let of_all = (base - named) / (base - lowest).max(1e-9);
    let of_explainable = (base - named) / (base - explainable.max(3.0).min(base)).max(1e-9);
    if of_all < NAMED {
        Verdict::Unexplained
    } else if of_explainable >= EXPLAINED && of_all >= LEAST {
        Verdict::Explained
    } else {
        Verdict::PartlyExplained
    }
}
