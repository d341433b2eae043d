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
    /// Adds sets of the screening to a hypothesis and fits them, best first.
    pub(super) fn fit_subsets(&self, from: &Hypothesis, subsets: &[&Subset<'_>]) -> Vec<Scored> {
        let starts = subsets.iter().map(|subset| {
            subset.starts.iter().fold(from.clone(), |h, s| h.with(s.candidate, &s.values))
        });
        self.fit_all(starts.collect())
    }

    /// Fits hypotheses from their values, a few iterations each, and follows the most promising to convergence. Best first;
    /// those that are the same set count once.
    pub(super) fn fit_all(&self, starts: Vec<Hypothesis>) -> Vec<Scored> {
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
        let mut sets = fitted(starts, settings.first_iterations);
        let rest = sets.split_off(settings.followed.min(sets.len()));
        let followed = sets.into_iter().map(|s| s.fit.hypothesis).collect();
        let mut all = fitted(followed, settings.iterations);
        all.extend(rest);
        best_first(all)
    }

    /// A set without the member at `place`, fitted again.
    pub(crate) fn fitted_without(&self, set: &Scored, place: usize) -> Option<Scored> {
        self.fitted(set.hypothesis().without(place), self.whole.settings.search.iterations)
    }
}
