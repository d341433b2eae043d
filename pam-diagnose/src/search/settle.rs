//! The end of a search: the chosen names, fitted to everything that may be fitted.

use super::explore::{Scored, Search};
use super::forward::{Acceptance, Findings};
use crate::fit::{Hypothesis, Local};
use pam_effects::effects::EffectScalar;
use rayon::prelude::*;

/// A set of names, as the search chose it and as all open recordings fit it.
#[derive(Debug, Clone)]
pub struct Settled<'e> {
    /// Fitted to a part of the recordings, judged by the others.
    pub chosen: Scored<'e>,
    /// The same effects fitted to all of them.
    pub whole: Scored<'e>,
}

/// Difference of the cost within which a set is fitted to everything before it is dropped.
const CLOSE: f64 = 60.0;
/// Most sets that are fitted to everything.
const RIVALS: usize = 5;
/// Most sets that are followed to the end.
const FINALISTS: usize = 3;
/// Iterations before sets are compared.
const COMPARING: usize = 8;
/// Iterations to the end.
const POLISHING: usize = 20;
/// Factors of the numbers of dry friction from which a set is followed again.
const RUGGED: [f64; 2] = [0.75, 1.33];
/// Difference of the cost below which two shapes of one effect fit equally well.
const AS_WELL: f64 = 12.0;

impl<'e> Search<'_, 'e> {
    /// Fits the set that a search chose, and those that came close, to this search's recordings: all that may
    /// be fitted. The errors of dry friction are rugged in its numbers, and a set that was left in a poor
    /// valley must not lose by that, so the best are followed to the end before one is taken. A larger set
    /// must be better by `asked.total_drop` for each effect more.
    ///
    /// `None` if nothing was chosen, or every fit diverges.
    #[must_use]
    pub fn settle(&self, found: &Findings<'e>, asked: &Acceptance) -> Option<Settled<'e>> {
        let members = |s: &Scored<'e>| s.fit.hypothesis.ids().len();
        if members(&found.best) == 0 {
            return None;
        }
        let price = |s: &Scored<'e>, total: f64| total + asked.total_drop * members(s) as f64;
        let sorted = |s: &Scored<'e>| {
            let mut ids = s.fit.hypothesis.ids();
            ids.sort_unstable();
            ids
        };
        let bound = price(&found.best, found.best.total) + CLOSE;
        let mut sets = vec![found.best.clone()];
        for other in &found.others {
            let close = price(other, other.total) < bound;
            if close && sets.len() < RIVALS && sets.iter().all(|s| sorted(s) != sorted(other)) {
                sets.push(other.clone());
            }
        }
        let by_price = |a: &Settled<'e>, b: &Settled<'e>| {
            price(&a.whole, a.whole.total).total_cmp(&price(&b.whole, b.whole.total))
        };
        let mut fitted: Vec<Settled<'e>> = sets
            .into_par_iter()
            .filter_map(|chosen| {
                let start = self.opened(&chosen.fit.hypothesis);
                let fit = self.split.train.fit(start, COMPARING).ok()?;
                self.score(fit).map(|whole| Settled { chosen, whole })
            })
            .collect();
        fitted.sort_by(by_price);
        let best = fitted.first().map(|s| price(&s.whole, s.whole.total))?;
        fitted.retain(|s| price(&s.whole, s.whole.total) < best + CLOSE);
        fitted.truncate(FINALISTS);
        let mut followed: Vec<Settled<'e>> = fitted
            .into_iter()
            .map(|s| Settled { whole: self.polish(s.whole), chosen: s.chosen })
            .collect();
        followed.sort_by(by_price);
        let sound = |s: &&Settled<'e>| {
            self.stands(&s.whole.fit.hypothesis) && self.insignificant(&s.whole).is_none()
        };
        followed.iter().find(sound).or(followed.first()).cloned()
    }

    /// The hypothesis with the uncertain numbers of this search's trials as measured.
    fn opened(&self, hypothesis: &Hypothesis<'e>) -> Hypothesis<'e> {
        let locals = vec![Local::default(); self.split.train.len()];
        Hypothesis { locals, ..hypothesis.clone() }
    }

    /// The set without the effect at `place`, fitted again in both ways.
    #[must_use]
    pub fn settle_without(
        &self,
        choosing: &Self,
        settled: &Settled<'e>,
        place: usize,
    ) -> Option<Settled<'e>> {
        let refit = |search: &Self, s: &Scored<'e>| {
            let less = s.fit.hypothesis.without(place);
            search.split.train.fit(less, 10).ok().and_then(|fit| search.score(fit))
        };
        let chosen = refit(choosing, &settled.chosen)?;
        refit(self, &settled.whole).map(|whole| Settled { chosen, whole })
    }

    /// Follows a set to the end, from where it is, from every starting value of each member (scales have
    /// several valleys), and with the numbers of dry friction made smaller and larger: where the joint sticks
    /// and slips, the errors are rugged in them.
    fn polish(&self, best: Scored<'e>) -> Scored<'e> {
        let h = &best.fit.hypothesis;
        let mut starts = vec![h.clone()];
        for at in h.fixed..h.effects.len() {
            let all = h.effects[at].starts(&self.scales);
            if all.len() > 1 {
                starts.extend(all.into_iter().map(|values| {
                    let mut other = h.clone();
                    other.values[h.value_range(at)].copy_from_slice(&values);
                    other
                }));
            }
            let values = &h.values[h.value_range(at)];
            let sticks = f64::hooks(h.effects[at]).dry_friction_mn(values, 0.0) > 0.0;
            for k in 0..if sticks { h.effects[at].info().parameters.len() } else { 0 } {
                starts.extend(RUGGED.map(|factor| {
                    let mut other = h.clone();
                    other.values[h.value_range(at).start + k] *= factor;
                    other
                }));
            }
        }
        starts
            .into_par_iter()
            .filter_map(|start| {
                let fit = self.split.train.fit(start, POLISHING).ok()?;
                self.stands(&fit.hypothesis).then(|| self.score(fit)).flatten()
            })
            .collect::<Vec<_>>()
            .into_iter()
            .fold(best, |best, other| if other.total < best.total { other } else { best })
    }

    /// Values that the effect at `place` takes in those of its other shapes (switches) that fit the data as
    /// well: within the cost at which one parameter is worth it.
    #[must_use]
    pub fn other_shapes(&self, best: &Scored<'e>, place: usize) -> Vec<Vec<f64>> {
        let h = &best.fit.hypothesis;
        let at = h.fixed + place;
        let info = h.effects[at].info();
        let switches = info.parameters.len()..info.value_len();
        let own = &h.values[h.value_range(at)];
        let mut tried: Vec<Vec<f64>> = vec![own[switches.clone()].to_vec()];
        let mut found = Vec::new();
        for start in h.effects[at].starts(&self.scales) {
            let shape = start[switches.clone()].to_vec();
            if tried.contains(&shape) {
                continue;
            }
            tried.push(shape.clone());
            let mut other = h.clone();
            let range = other.value_range(at);
            other.values[range][switches.clone()].copy_from_slice(&shape);
            let fit = self.split.train.fit(other, 8).ok().and_then(|fit| self.score(fit));
            if let Some(s) = fit.filter(|s| s.total < best.total + AS_WELL) {
                let h = &s.fit.hypothesis;
                found.push(h.values[h.value_range(at)].to_vec());
            }
        }
        found
    }
}
