//! Sets of effects: forward in a beam, then backward.

use super::explore::{Scored, Search};
use crate::fit::Interval;
use pam_effects::effects::{AnyEffect, ParameterInfo};
use rayon::prelude::*;

/// When an effect earns its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Acceptance {
    /// Least drop of the deviance of held-out rows, `Σ_c Δ ln(MSE_c + floor_c²)`.
    pub held_drop: f64,
    /// Least drop of the whole cost (log-likelihood of all rows with complexity).
    pub total_drop: f64,
}

impl Default for Acceptance {
    fn default() -> Self {
        Self { held_drop: 0.08, total_drop: 12.0 }
    }
}

/// What a search found.
#[derive(Debug, Clone)]
pub struct Findings<'e> {
    /// The base model.
    pub base: Scored<'e>,
    /// Every candidate alone, best first.
    pub singles: Vec<Scored<'e>>,
    /// The chosen set; the base if nothing earned its place.
    pub best: Scored<'e>,
    /// Sets that came close, best first.
    pub others: Vec<Scored<'e>>,
}

/// Sets that are extended at each size.
const BEAM: usize = 3;
/// Level (see [`Search::level`]) below which nothing more is asked.
const SATISFIED: f64 = 4.5;
/// Level below which errors of the model itself are as large as what is left, so that one more effect must be
/// worth [`STRICT`] times as much.
const NEAR_FLOORS: f64 = 6.0;
/// See [`NEAR_FLOORS`]. On the virtual rig's model effects that are there are worth six times the usual at such
/// levels, and those that only follow the model's errors up to four times.
const STRICT: f64 = 5.0;
/// Candidates that are followed to the end beside a set.
const FOLLOWED: usize = 6;

impl<'e> Search<'_, 'e> {
    fn drop(&self, from: &Scored<'e>, to: &Scored<'e>) -> (f64, f64) {
        let floors = &self.split.held.floors;
        (from.held.deviance(floors) - to.held.deviance(floors), from.total - to.total)
    }

    fn earns(&self, from: &Scored<'e>, to: &Scored<'e>, asked: &Acceptance) -> bool {
        let (held, total) = self.drop(from, to);
        held >= asked.held_drop && total >= asked.total_drop
    }

    /// Squared error of all rows in units of the floors; three for a residual at the floors.
    #[must_use]
    pub fn level(&self, scored: &Scored<'e>) -> f64 {
        scored.fit.errors.and(&scored.held).in_floors(&self.split.held.floors)
    }

    /// Searches for the set of at most `most` effects that explains best what the base model and the fixed
    /// effects leave. `done` is called with the share of the work that is behind.
    ///
    /// Sets grow in a beam of the three best of each size, so that an effect that only shows beside another
    /// is found; each growth must earn its place on held-out rows, and in the end each member must still be
    /// worth it.
    pub fn run(
        &self,
        fixed: &[(&'e dyn AnyEffect, Vec<f64>)],
        most: usize,
        asked: &Acceptance,
        done: &(dyn Fn(f64) + Sync),
    ) -> Option<Findings<'e>> {
        let base = self.base(fixed)?;
        done(0.05);
        let singles = self.singles(&base.fit.hypothesis);
        done(0.3);
        let mut best = base.clone();
        let mut others = singles.clone();
        let mut beam: Vec<Scored<'e>> = singles.iter().take(BEAM).cloned().collect();
        if let Some(first) = beam.first()
            && self.earns(&best, first, asked)
        {
            best = first.clone();
        }
        for size in 2..=most {
            // A pair may show what neither shows alone; beyond that, only a set that grew grows on.
            let grown = best.fit.hypothesis.ids().len() + 1 == size;
            if !(grown || size == 2) || self.level(&best) < SATISFIED || beam.is_empty() {
                break;
            }
            let mut next: Vec<Scored<'e>> = Vec::new();
            for set in &beam {
                for scored in self.beside(&set.fit.hypothesis, &singles, FOLLOWED) {
                    let mut ids = scored.fit.hypothesis.ids();
                    ids.sort_unstable();
                    let known = next.iter_mut().find(|s| {
                        let mut other = s.fit.hypothesis.ids();
                        other.sort_unstable();
                        other == ids
                    });
                    match known {
                        Some(k) if scored.total < k.total => *k = scored,
                        Some(_) => {}
                        None => next.push(scored),
                    }
                }
            }
            next.sort_by(|a, b| a.total.total_cmp(&b.total));
            let Some(top) = next.first().cloned() else { break };
            let members = top.fit.hypothesis.ids().len() - best.fit.hypothesis.ids().len();
            let strict = if self.level(&best) < NEAR_FLOORS { STRICT } else { 1.0 };
            let more = Acceptance {
                held_drop: asked.held_drop * strict * members as f64,
                total_drop: asked.total_drop * strict * members as f64,
            };
            let earned = self.earns(&best, &top, &more);
            if earned || strict == 1.0 {
                others.extend(next.iter().cloned());
            }
            if !earned {
                break;
            }
            best = top;
            beam = next.into_iter().take(BEAM).collect();
            done(0.3 + 0.6 * size as f64 / most as f64);
        }
        best = self.significant(self.backward(best, asked), asked);
        others.sort_by(|a, b| a.total.total_cmp(&b.total));
        done(1.0);
        Some(Findings { base, singles, best, others })
    }

    /// Drops members whose own parameters do not say that they are there: every parameter that could switch
    /// the effect off has an interval that holds that value, or a scale has no interval to speak of.
    fn significant(&self, mut best: Scored<'e>, asked: &Acceptance) -> Scored<'e> {
        while let Some(place) = self.insignificant(&best) {
            let less = best.fit.hypothesis.without(place);
            let refitted = self.split.train.fit(less, 8).ok().and_then(|fit| self.score(fit));
            match refitted {
                Some(less) => best = self.backward(less, asked),
                None => break,
            }
        }
        best
    }

    pub(super) fn insignificant(&self, scored: &Scored<'e>) -> Option<usize> {
        let intervals = self.split.train.intervals(&scored.fit).ok()?;
        let mut at = 0;
        for (place, (effect, _)) in scored.fit.hypothesis.fitted().enumerate() {
            let parameters = effect.info().parameters;
            let own = &intervals[at..at + parameters.len()];
            at += parameters.len();
            let pairs = || parameters.iter().zip(own);
            let holds_off = |p: &ParameterInfo, i: &Interval| {
                p.off.is_none_or(|off| i.ci95[0] <= off && off <= i.ci95[1])
            };
            let switchable = parameters.iter().any(|p| p.off.is_some());
            let absent = switchable && pairs().all(|(p, i)| holds_off(p, i));
            // An interval without a number is vague as well.
            let narrow = |i: &Interval| i.ci95[1] <= 100.0 * i.ci95[0];
            let vague = pairs().any(|(p, i)| p.logarithmic && !narrow(i));
            if absent || vague {
                return Some(place);
            }
        }
        None
    }

    /// Drops members that are not worth their place once the others are there.
    fn backward(&self, mut best: Scored<'e>, asked: &Acceptance) -> Scored<'e> {
        loop {
            let members = best.fit.hypothesis.ids().len();
            if members < 2 {
                return best;
            }
            let without: Vec<Scored<'e>> = (0..members)
                .into_par_iter()
                .filter_map(|place| {
                    let less = best.fit.hypothesis.without(place);
                    self.score(self.split.train.fit(less, 6).ok()?)
                })
                .collect();
            let dropped = without
                .into_iter()
                .filter(|less| !self.earns(less, &best, asked))
                .min_by(|a, b| a.total.total_cmp(&b.total));
            match dropped {
                Some(less) => best = less,
                None => return best,
            }
        }
    }
}
