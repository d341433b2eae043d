//! A named cause, and the candidates alone.

use super::outcome::share;
use crate::data::Split;
use crate::fit::{Interval, Member};
use crate::rejection::ParameterStability;
use crate::search::{Candidates, Scored, beside, refit_without};
use crate::settings::RejectionSettings;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

/// A named cause with its evidence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cause {
    /// Id of the candidate.
    pub effect: String,
    /// What it is.
    #[serde(skip)]
    pub description: String,
    /// Parameters by name.
    #[serde(serialize_with = "by_name")]
    pub parameters: Vec<(&'static str, Interval)>,
    /// Share of the removable error of training and validation rows that only this cause removes.
    pub share_of_error_removed: f64,
    /// Candidates that explain nearly as much in its place.
    pub confusable_with: Vec<String>,
    /// The same candidates with their fitted values.
    #[serde(skip)]
    pub alternatives: Vec<Member>,
    /// Which excitation brings it out.
    pub excited_by: String,
    /// Its value in parts of the recordings.
    pub stability: Option<ParameterStability>,
    /// The candidate with its fitted values.
    #[serde(skip)]
    pub member: Member,
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
}

/// A candidate alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rank {
    /// Id of the candidate.
    pub effect: String,
    /// Share of the removable error that it removes alone, 0 to 1.
    pub score: f64,
    /// Its fitted values.
    #[serde(skip)]
    pub values: Vec<f64>,
    /// Parameters that ended at a limit of their range.
    pub at_limit: Vec<&'static str>,
}

/// The candidates alone, best first.
pub(crate) fn ranking<C: Candidates + ?Sized>(
    split: &Split<'_, C>,
    base: &Scored,
    singles: &[Scored],
) -> Vec<Rank> {
    let noise = &split.train.noise;
    let from = base.chi_square(noise);
    let lowest = singles.iter().map(|s| s.chi_square(noise)).fold(1.0, f64::min);
    singles
        .iter()
        .filter_map(|s| {
            let member = s.hypothesis().members.last()?;
            Some(Rank {
                effect: split.train.system.candidate(member.candidate).id.to_owned(),
                score: share(from, s.chi_square(noise), lowest),
                values: member.values.clone(),
                at_limit: s.fit.at_limit.clone(),
            })
        })
        .collect()
}

/// Candidates that explain nearly as much in place of the member at `place` of a set, with the values that they take
/// there.
pub(super) fn confusable<C: Candidates + ?Sized>(
    split: &Split<'_, C>,
    base: &Scored,
    best: &Scored,
    place: usize,
    singles: &[Scored],
) -> Vec<Member> {
    let settings = split.train.settings;
    let noise = &split.train.noise;
    let (without, alternatives) = if best.members() == 1 {
        (base.chi_square(noise), singles.to_vec())
    } else {
        let iterations = settings.search.drop_iterations;
        let Some(less) = refit_without(split, best, place, iterations) else {
            return Vec::new();
        };
        let tried = settings.verdict.confusable_tried;
        (less.chi_square(noise), beside(split, less.hypothesis(), singles, tried))
    };
    let named = best.chi_square(noise);
    let removed = |chi: f64| share(without, chi, named.min(1.0));
    let asked = settings.verdict.confusable_share * removed(named);
    alternatives
        .iter()
        .filter(|s| removed(s.chi_square(noise)) >= asked)
        .filter_map(|s| s.hypothesis().members.last().cloned())
        .filter(|m| !best.hypothesis().contains(m.candidate))
        .collect()
}
