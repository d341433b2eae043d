//! Sets of candidates from the screening, fitted.

use super::candidates::Candidates;
use super::rows::Rows;
use super::scored::{Scored, complexity};
use crate::fit::{Fit, Hypothesis, Problem};
use crate::linearised::Subset;
use pam_core::parallel;

/// Whether every member still is what its name says.
pub(crate) fn stands<C: Candidates + ?Sized>(system: &C, hypothesis: &Hypothesis) -> bool {
    hypothesis.members.iter().all(|m| system.stands(m.candidate, m.own()))
}

/// Fits hypotheses from their values. After every few iterations only those go on whose price may still come within a margin of the lowest
/// one, or of the price of a rival if that is lower, and after some more iterations only the most promising of them.
pub(crate) fn fit_promising<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    starts: Vec<Hypothesis>,
    price: impl Fn(&Fit) -> f64,
    (rival, margin): (f64, f64),
) -> Vec<Fit> {
    let settings = &problem.settings.search;
    let fitted = parallel::map_each(starts, |start| {
        problem.fit_to(start, settings.first_iterations, settings.converged_drop)
    });
    let mut going: Vec<Fit> = fitted.into_iter().flatten().collect();
    let mut done = Vec::new();
    let mut iterations = settings.first_iterations;
    while !going.is_empty() {
        let limit = going.iter().chain(&done).map(&price).fold(rival, f64::min) + margin;
        going.sort_by(|a, b| price(a).total_cmp(&price(b)));
        let mut followed = 0;
        let (further, ended): (Vec<Fit>, Vec<Fit>) = going.into_iter().partition(|fit| {
            let near = price(fit) + fit.may_reach() - fit.cost < limit;
            let goes_on = near && !fit.has_converged() && iterations < settings.iterations;
            followed += usize::from(goes_on);
            goes_on && (iterations < settings.tried_iterations || followed <= settings.followed)
        });
        done.extend(ended);
        iterations += settings.first_iterations;
        let go_on = |fit| problem.fit_further(fit, settings.first_iterations);
        going = parallel::map_each(further, go_on).into_iter().flatten().collect();
    }
    done
}

impl Subset<'_> {
    /// Its candidates at their starting values, beside the members of a hypothesis.
    pub(super) fn beside(&self, from: &Hypothesis) -> Hypothesis {
        self.starts.iter().fold(from.clone(), |h, s| h.with(s.candidate, &s.values))
    }
}

impl<C: Candidates + ?Sized> Rows<'_, C> {
    /// Adds sets of the screening to a hypothesis and fits them, best first, as [`fit_all`](Self::fit_all) does.
    pub(super) fn fit_subsets(
        &self,
        from: &Hypothesis,
        subsets: &[&Subset<'_>],
        rival: Option<&Scored>,
    ) -> Vec<Scored> {
        self.fit_all(subsets.iter().map(|subset| subset.beside(from)).collect(), rival)
    }

    /// Fits hypotheses from their values as [`fit_promising`] does, and scores them. Only those are followed that may still come near the
    /// best of them, or the `rival` if that is better, by the training rows. Best first; those that are the same set count once.
    pub(super) fn fit_all(&self, starts: Vec<Hypothesis>, rival: Option<&Scored>) -> Vec<Scored> {
        let price = |fit: &Fit| fit.cost + complexity(&self.choosing, fit);
        let rival = rival.map_or(f64::INFINITY, |r| price(&r.fit));
        let limit = (rival, self.confusable_cost());
        let done = fit_promising(&self.choosing.train, starts, price, limit);
        let scored = parallel::map_each(done, |fit| self.scored(fit));
        let rows = self.whole.rows_per_observation;
        let mut sets: Vec<Scored> = scored.into_iter().flatten().collect();
        sets.sort_by(|a, b| a.total(rows).total_cmp(&b.total(rows)));
        let mut known = std::collections::HashSet::new();
        sets.retain(|s| known.insert(s.hypothesis().set()));
        sets
    }

    /// A hypothesis with the amplitudes of its last member made larger by the factor of the settings at which it costs the training
    /// rows least: where responses are far from linear, a fit from small amplitudes may not come to large ones.
    pub(super) fn at_best_amplitude(&self, start: Hypothesis) -> Hypothesis {
        let train = &self.choosing.train;
        let cost = |h: &Hypothesis| train.errors(h).map_or(f64::INFINITY, |e| train.cost(h, &e));
        let Some(last) = start.members.len().checked_sub(1) else { return start };
        let factors = self.whole.settings.search.amplitude_factors;
        let larger = factors.map(|factor| start.with_magnitudes(self.whole.system, last, factor));
        let mut all = vec![start];
        all.extend(larger);
        all.dedup_by(|a, b| a.members == b.members);
        let costs = parallel::map_each(all, |h| (cost(&h), h));
        let best = costs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        best.expect("the start is among them").1
    }

    /// Difference of minus two times the logarithm of the probability below which sets may be confused.
    pub(super) fn confusable_cost(&self) -> f64 {
        2.0 * self.whole.settings.verdict.confusable_odds.ln()
    }

    /// A set without the member at `place`, fitted again.
    pub(crate) fn fitted_without(&self, set: &Scored, place: usize) -> Option<Scored> {
        self.fitted(set.hypothesis().without(place), self.whole.settings.search.iterations)
    }
}
