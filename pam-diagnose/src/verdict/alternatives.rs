//! Candidates that are not named: those that may be in the place of a cause, and those that are refused.

use super::cause::Refused;
use super::naming::Naming;
use crate::fit::{Fit, Hypothesis, Member};
use crate::onset::TimedSet;
use crate::search::{Candidates, Scored};
use std::collections::HashSet;

impl<C: Candidates + ?Sized> Naming<'_, '_, C> {
    /// Candidates that explain nearly as much in place of a member of the chosen set: sets with another candidate in its
    /// place against which the odds are not enough, or that remove nearly as much of the error, so that a model that is not
    /// quite right may have decided between them.
    pub(super) fn alternatives(&self, best: &Fit, place: usize) -> Vec<Member> {
        let candidate = best.hypothesis.members[place].candidate;
        if let Some(timed) = self.timed {
            return self.alternatives_in_time(timed, &best.hypothesis, place);
        }
        let chosen = &self.found.best;
        // A rival of the chosen set, whose causes were refused, has those in its place.
        let of_chosen = chosen.hypothesis().set();
        let is_rival = best.hypothesis.set().iter().any(|c| !of_chosen.contains(c));
        let set = if is_rival { best.hypothesis.set() } else { of_chosen };
        let rest: Vec<usize> = set.iter().copied().filter(|&c| c != candidate).collect();
        let settings = &self.rows.whole.settings.verdict;
        let limit = settings.confusable_odds.ln();
        let place = chosen.hypothesis().members.iter().position(|m| m.candidate == candidate);
        let less = place.and_then(|p| self.found.without.get(p)).and_then(Option::as_ref);
        let less = less.unwrap_or(&self.found.base).chi_square();
        let removed = less - chosen.chi_square();
        let nearly = |s: &Scored| {
            chosen.log_odds(s) < limit
                || less - s.chi_square() > settings.confusable_share * removed
        };
        let in_place = |s: &&Scored| {
            let h = s.hypothesis();
            h.members.len() == set.len()
                && !h.contains(candidate)
                && rest.iter().all(|&c| h.contains(c))
        };
        let near = self.found.others.iter().filter(in_place);
        near.filter(|s| nearly(s))
            .filter_map(|s| {
                let other = |m: &&Member| !set.contains(&m.candidate);
                s.hypothesis().members.iter().find(other).cloned()
            })
            .collect()
    }

    /// As [`alternatives`](Self::alternatives), among the sets in which something begins or ends.
    fn alternatives_in_time(
        &self,
        timed: &TimedSet,
        best: &Hypothesis,
        place: usize,
    ) -> Vec<Member> {
        let settings = &self.rows.whole.settings.verdict;
        let candidate = best.members[place].candidate;
        let rest: Vec<usize> = best.set().into_iter().filter(|&c| c != candidate).collect();
        let least = timed.others.first().map_or(0.0, |s| s.1);
        let near = timed.others.iter().filter(|(h, total)| {
            h.members.len() == best.members.len()
                && !h.contains(candidate)
                && rest.iter().all(|&c| h.contains(c))
                && total - least < 2.0 * settings.confusable_odds.ln()
        });
        // The best times of each candidate come first.
        let mut known = HashSet::new();
        near.filter_map(|(h, _)| h.members.iter().find(|m| !best.contains(m.candidate)).cloned())
            .filter(|m| known.insert(m.candidate))
            .collect()
    }

    /// The posterior probability that each candidate is at work, over the sets that were fitted in the last round, by
    /// their totals (Hoeting and others 1999).
    pub(super) fn inclusion(&self) -> Vec<f64> {
        let sets: Vec<(&Hypothesis, f64)> = if let Some(timed) = self.timed {
            let least = timed.others.first().map_or(0.0, |s| s.1);
            timed.others.iter().map(|(h, total)| (h, (0.5 * (least - total)).exp())).collect()
        } else {
            let odds = |s: &Scored| (-self.found.best.log_odds(s)).min(0.0).exp();
            self.found.others.iter().map(|s| (s.hypothesis(), odds(s))).collect()
        };
        let all: f64 = sets.iter().map(|s| s.1).sum();
        let of = |candidate: usize| {
            let with = sets.iter().filter(|(h, _)| h.contains(candidate));
            // An empty sum is −0.
            0.0 + with.map(|s| s.1).sum::<f64>() / all.max(f64::MIN_POSITIVE)
        };
        (0..self.rows.whole.system.candidate_len()).map(of).collect()
    }

    /// Lists every candidate that is neither named nor refused yet.
    pub(super) fn refuse_others(&self, named: &Hypothesis, refused: &mut Vec<Refused>) {
        let system = self.rows.whole.system;
        let inclusion = self.inclusion();
        let best = &self.found.best;
        for (candidate, &inclusion) in inclusion.iter().enumerate() {
            let id = system.candidate(candidate).id;
            if named.contains(candidate) || refused.iter().any(|r| r.effect == id) {
                continue;
            }
            let sets = self.found.others.iter().filter(|s| s.hypothesis().contains(candidate));
            let odds = sets.map(|s| s.log_odds(best)).fold(f64::NEG_INFINITY, f64::max);
            let by_chance = self.found.null_test.as_ref().is_some_and(|t| {
                t.p_value > 1.0 - self.rows.whole.settings.rejection.null_quantile
            });
            let reason = if odds > f64::NEG_INFINITY {
                format!("sets with it are not better: logarithm of the odds {odds:.1}")
            } else if by_chance {
                "no candidate explains more than chance".to_owned()
            } else {
                "it explains less than the candidates that were fitted, to first order".to_owned()
            };
            refused.push(Refused { effect: id.to_owned(), inclusion, reason });
        }
    }
}
