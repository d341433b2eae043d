//! A named cause.

use crate::fit::{Floors, Interval};
use crate::search::{Constancy, Scored, Search};
use pam_effects::effects::AnyEffect;
use pam_effects::model::ActiveEffect;
use serde::Serialize;

/// A named effect with what speaks for it.
#[derive(Debug, Clone, Serialize)]
pub struct Cause {
    /// Id of the effect.
    pub effect: &'static str,
    /// What it is.
    pub what: &'static str,
    /// Parameters by name.
    pub parameters: Vec<(&'static str, Interval)>,
    /// Share of the removable error (held-out and fitted rows) that goes away with this effect beside the
    /// others.
    pub share_of_error_removed: f64,
    /// Effects that explain nearly as much in its place.
    pub confusable_with: Vec<&'static str>,
    /// The same effects with their fitted values.
    #[serde(skip)]
    pub alternatives: Vec<ActiveEffect>,
    /// Which excitation brings it out.
    pub excited_by: &'static str,
    /// Its value in parts of the recordings.
    pub constancy: Option<Constancy>,
}

/// Spread of a cause's value over parts of the recordings beyond which the name only mimics another cause.
const MIMICS: f64 = 0.6;

impl Cause {
    /// Whether the effect has no common value in the parts of the recordings, and does not explain the error
    /// either: a jump or an event that the name takes the mean of.
    #[must_use]
    pub fn mimics(&self) -> bool {
        let spread = self.constancy.as_ref().map_or(0.0, |c| c.relative_spread);
        spread > MIMICS && self.share_of_error_removed < 0.8
    }
}

/// A candidate alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rank {
    /// Id of the effect.
    pub effect: &'static str,
    /// Share of the removable error that it removes alone, 0 to 1.
    pub score: f64,
    /// Its fitted values.
    pub values: Vec<f64>,
    /// Parameters that ended at the limit of what is possible.
    pub at_limit: Vec<&'static str>,
}

/// An effect counts as confusable if it removes at least this share of what the named one removes.
const NEARLY: f64 = 0.85;

/// Errors on all rows in units of the floors.
pub(super) fn level(scored: &Scored<'_>, floors: &Floors) -> f64 {
    scored.fit.errors.and(&scored.held).in_floors(floors)
}

/// Share of the removable error that goes from one level to another; the floors count three.
pub(super) fn share(from: f64, to: f64, lowest: f64) -> f64 {
    let removable = (from - lowest).max(1e-9);
    ((from - to) / removable).clamp(0.0, 1.0)
}

/// Level of a residual at its floor in all channels.
pub(super) fn floor_level(best: f64) -> f64 {
    best.min(3.0)
}

impl<'e> Search<'_, 'e> {
    /// Ids of candidates that explain nearly as much in place of the effect at `place` of a set, with the
    /// values that they take there.
    pub(super) fn confusable(
        &self,
        base: &Scored<'e>,
        best: &Scored<'e>,
        place: usize,
        singles: &[Scored<'e>],
    ) -> Vec<(&'static str, Vec<f64>)> {
        let floors = &self.split.held.floors;
        let members = best.fit.hypothesis.ids().len();
        let own = best.fit.hypothesis.ids()[place];
        let (without, alternatives) = if members == 1 {
            (level(base, floors), singles.to_vec())
        } else {
            let less = best.fit.hypothesis.without(place);
            let Some(less) = self.split.train.fit(less, 6).ok().and_then(|f| self.score(f)) else {
                return Vec::new();
            };
            (level(&less, floors), self.beside(&less.fit.hypothesis, singles, 8))
        };
        let named = level(best, floors);
        let gained = share(without, named, floor_level(named));
        alternatives
            .iter()
            .filter_map(|s| {
                let (effect, values) = s.fit.hypothesis.fitted().last()?;
                let id = effect.info().id;
                let taken = best.fit.hypothesis.ids().contains(&id);
                let near = share(without, level(s, floors), floor_level(named)) >= NEARLY * gained;
                (id != own && !taken && near).then(|| (id, values.to_vec()))
            })
            .collect()
    }
}

/// The candidates alone, best first.
pub(super) fn ranking(base: &Scored<'_>, singles: &[Scored<'_>], floors: &Floors) -> Vec<Rank> {
    let from = level(base, floors);
    let lowest = singles.iter().map(|s| level(s, floors)).fold(3.0, f64::min);
    singles
        .iter()
        .filter_map(|s| {
            let (effect, values) = s.fit.hypothesis.fitted().last()?;
            Some(Rank {
                effect: effect.info().id,
                score: share(from, level(s, floors), lowest),
                values: values.to_vec(),
                at_limit: s.fit.at_limit.clone(),
            })
        })
        .collect()
}

/// The id and words of an effect.
pub(super) fn words(effect: &dyn AnyEffect) -> (&'static str, &'static str, &'static str) {
    let info = effect.info();
    (info.id, info.description, info.excited_by)
}
