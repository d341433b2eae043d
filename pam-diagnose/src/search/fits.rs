//! Sets of candidates from the screening, fitted.

use super::candidates::Candidates;
use super::rows::Rows;
use super::scored::Scored;
use crate::fit::Hypothesis;
use crate::linearised::Subset;
use pam_core::parallel;

/// Whether every member still is what its name says.
pub(crate) fn stands<C: Candidates + ?Sized>(system: &C, hypothesis: &Hypothesis) -> bool {
    hypothesis.members.iter().all(|m| system.stands(m.candidate, &m.values))
}

impl<C: Candidates + ?Sized> Rows<'_, C> {
    /// Adds sets of the screening to a hypothesis and fits them, best first, as [`fit_all`](Self::fit_all) does.
    pub(super) fn fit_subsets(
        &self,
        from: &Hypothesis,
        subsets: &[&Subset<'_>],
        rival: Option<&Scored>,
    ) -> Vec<Scored> {
        let starts = subsets.iter().map(|subset| {
            subset.starts.iter().fold(from.clone(), |h, s| h.with(s.candidate, &s.values))
        });
        self.fit_all(starts.collect(), rival)
    }

    /// Fits hypotheses from their values, a few iterations each, and follows to convergence those that may still come near
    /// the best of them, or the `rival` if that is better. Best first; those that are the same set count once.
    pub(super) fn fit_all(&self, starts: Vec<Hypothesis>, rival: Option<&Scored>) -> Vec<Scored> {
        let settings = &self.whole.settings.search;
        let rows = self.whole.rows_per_observation;
        let best_first = |mut sets: Vec<Scored>| {
            sets.sort_by(|a, b| a.total(rows).total_cmp(&b.total(rows)));
            let mut known = std::collections::HashSet::new();
            sets.retain(|s| known.insert(s.hypothesis().set()));
            sets
        };
        let fitted = |starts: Vec<Hypothesis>, iterations: usize| -> Vec<Scored> {
            let each = parallel::map_each(starts, |start| self.fitted(start, iterations));
            best_first(each.into_iter().flatten().collect())
        };
        let sets = fitted(starts, settings.first_iterations);
        let lowest = sets.iter().chain(rival).map(|s| s.total(rows)).fold(f64::INFINITY, f64::min);
        let limit = lowest + self.confusable_cost();
        let mut followed = 0;
        let (again, mut all): (Vec<Scored>, Vec<Scored>) = sets.into_iter().partition(|s| {
            let moves = s.fit.last_drop >= self.whole.settings.fit.converged_drop;
            let near = s.total(rows) + s.fit.may_reach() - s.fit.cost < limit;
            followed += usize::from(moves && near);
            moves && near && followed <= settings.followed
        });
        all.extend(fitted(
            again.into_iter().map(|s| s.fit.hypothesis).collect(),
            settings.iterations,
        ));
        best_first(all)
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
