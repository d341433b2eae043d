//! A named cause, a candidate that was not named, and the candidates alone.

use crate::fit::{Interval, Member};
use crate::onset::Times;
use crate::rejection::{ParameterStability, StabilityTest};
use crate::search::{Candidates, Findings};
use crate::settings::RejectionSettings;
use pam_vocabulary::ParameterInfo;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use std::collections::BTreeMap;

/// A named cause with its evidence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cause {
    /// Id of the candidate.
    pub effect: String,
    /// Description.
    #[serde(skip)]
    pub description: String,
    /// Parameters by name.
    #[serde(serialize_with = "by_name")]
    pub parameters: Vec<(&'static str, Interval)>,
    /// Share of the removable error of training and validation rows that only this cause removes.
    pub share_of_error_removed: f64,
    /// By how much the mean square of the channel that needs the cause most rises without it, the others being fitted anew,
    /// in units of the variance of the channel's noise.
    pub rise_without: f64,
    /// How far starts, masses and what else is uncertain must be from their measured values without it: their prior cost over
    /// its 99.9 % quantile, so that above 1 they are further than they can be.
    pub strain_without: f64,
    /// Whether it is small: it removes next to nothing of the error, or no more than a part of the noise, or is uncertain beside another
    /// cause; and starts and masses can be as measured without it.
    #[serde(skip)]
    pub minor: bool,
    /// True if the data are consistent with its absence: the confidence region of its magnitudes contains their off values or, if it still acts
    /// there, a likelihood-ratio test does not reject the fit without it.
    #[serde(skip)]
    pub(crate) may_be_absent: bool,
    /// The same with the region of all candidates at once (Bonferroni): the largest of many that are absent may look certain alone.
    #[serde(skip)]
    pub(crate) may_be_chance: bool,
    /// Posterior probability that it is at work, over the sets that were fitted.
    pub inclusion: f64,
    /// Candidates that explain nearly as much in its place.
    pub confusable_with: Vec<String>,
    /// The same candidates with their fitted values.
    #[serde(skip)]
    pub alternatives: Vec<Member>,
    /// The same candidates by name, with their fitted parameters.
    #[serde(rename = "alternatives", skip_serializing_if = "Vec::is_empty")]
    pub alternatives_by_name: Vec<Alternative>,
    /// Parameters that ended at a limit of their range.
    pub at_limit: Vec<&'static str>,
    /// Which excitation brings it out.
    pub excited_by: String,
    /// Its value in parts of the recordings.
    pub stability: Option<ParameterStability>,
    /// Whether its value is the same at all times and in all recordings.
    pub stability_test: StabilityTest,
    /// When it acts, if not always.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acts: Option<Times>,
    /// The candidate with its fitted values.
    #[serde(skip)]
    pub member: Member,
}

/// A candidate that explains nearly as much as a named cause in its place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Alternative {
    /// Id of the candidate.
    pub effect: String,
    /// Its fitted parameters.
    pub values: BTreeMap<String, f64>,
}

fn by_name<S: Serializer>(list: &[(&'static str, Interval)], to: S) -> Result<S::Ok, S::Error> {
    let mut map = to.serialize_map(Some(list.len()))?;
    for (name, interval) in list {
        map.serialize_entry(name, interval)?;
    }
    map.end()
}

impl Cause {
    /// Whether the cause has no common value in the parts of the recordings and does not explain the error either: a
    /// jump or an event of which the name takes the mean.
    #[must_use]
    pub(super) fn mimics(&self, settings: &RejectionSettings) -> bool {
        let spread = self.stability.as_ref().map_or(0.0, |c| c.relative_spread);
        spread > settings.mimic_spread && self.share_of_error_removed < settings.mimic_share
    }

    /// The largest distance of a parameter from the value at which it is absent, in halves of its interval on that side; 0 without such
    /// a parameter.
    pub(super) fn distance_from_absence(&self, infos: &[ParameterInfo]) -> f64 {
        let distance = |(info, (_, i)): (&ParameterInfo, &(&str, Interval))| {
            let off = info.off?;
            let end = if i.value < off { i.ci95[1] } else { i.ci95[0] };
            Some((i.value - off).abs() / (i.value - end).abs().max(f64::MIN_POSITIVE))
        };
        infos.iter().zip(&self.parameters).filter_map(distance).fold(0.0, f64::max)
    }
}

/// A candidate that is not named, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refused {
    /// Id of the candidate.
    pub effect: String,
    /// Posterior probability that it is at work, over the sets that were fitted.
    pub inclusion: f64,
    /// Why it is not named.
    pub reason: String,
}

/// A candidate alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rank {
    /// Id of the candidate.
    pub effect: String,
    /// Share of the whitened squared residual that it removes alone, 0 to 1: fitted where it is promising, else to first
    /// order.
    pub score: f64,
    /// Its fitted values; empty where it was screened only.
    #[serde(skip)]
    pub values: Vec<f64>,
    /// Parameters that ended at a limit of their range.
    pub at_limit: Vec<&'static str>,
}

/// The candidates alone, best first.
pub(crate) fn ranking<C: Candidates + ?Sized>(system: &C, found: &Findings) -> Vec<Rank> {
    let id = |candidate: usize| system.candidate(candidate).id.to_owned();
    let from = found.base.chi_square();
    let mut all: Vec<Rank> = found
        .screened
        .iter()
        .map(|&(candidate, score)| {
            let fitted = found.singles.iter().find(|s| s.hypothesis().contains(candidate));
            let Some(single) = fitted else {
                return Rank {
                    effect: id(candidate),
                    score,
                    values: Vec::new(),
                    at_limit: Vec::new(),
                };
            };
            let member = single.hypothesis().members.last();
            Rank {
                effect: id(candidate),
                score: (1.0 - single.chi_square() / from.max(1e-300)).clamp(0.0, 1.0),
                values: member.map(|m| m.values.clone()).unwrap_or_default(),
                at_limit: single.fit.at_limit.clone(),
            }
        })
        .collect();
    // Fitted scores count more than those to first order.
    let fitted = |r: &Rank| !r.values.is_empty();
    all.sort_by(|a, b| fitted(b).cmp(&fitted(a)).then(b.score.total_cmp(&a.score)));
    all
}
