//! From a chosen set to names that stand.

use super::cause::{Cause, Refused};
use crate::error::DiagnoseError;
use crate::fit::{Fit, Hypothesis, Problem};
use crate::onset::{TimedSet, moved_in_time};
use crate::rejection::vague;
use crate::search::refit::multi_start;
use crate::search::{Candidates, Findings, Rows, Scored};
use pam_core::parallel;

/// Multiple of what chance allows from which the prior cost of nuisances is an error of its own.
pub(crate) const STRAINED: f64 = 3.0;
/// Rise of the mean square of a channel by the variance of its noise.
const AS_LARGE_AS_NOISE: f64 = 1.0;

/// Everything from which names follow.
pub(crate) struct Naming<'n, 'a, C: ?Sized> {
    /// Training and validation rows.
    pub(crate) rows: &'n mut Rows<'a, C>,
    /// The result of the search.
    pub(crate) found: &'n Findings,
    /// Baseline recordings, if they were given.
    pub(crate) baseline: Option<&'n Problem<'a, C>>,
    /// A better set in which something begins or ends.
    pub(crate) timed: Option<&'n TimedSet>,
}

/// Names, from training and validation rows.
pub(crate) struct Names {
    /// The base model on all open rows.
    pub(crate) base: Fit,
    /// The base model with the named causes.
    pub(crate) best: Fit,
    /// The largest share of the error first.
    pub(crate) causes: Vec<Cause>,
    /// Candidates that are not named.
    pub(crate) refused: Vec<Refused>,
}

/// Why a name is rejected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rejection {
    MayBeAbsent,
    ScaleUndetermined,
    Mimics,
}

impl Rejection {
    fn reason(self) -> &'static str {
        match self {
            Self::MayBeAbsent => "its interval holds the value at which it is absent",
            Self::ScaleUndetermined => "the interval of its scale says nothing",
            Self::Mimics => {
                "it has no common value in the parts of the recordings: it takes the mean of something else"
            }
        }
    }
}

impl<C: Candidates + ?Sized> Naming<'_, '_, C> {
    /// Refits the chosen set and rejects names that stand for something else.
    pub(crate) fn names(&mut self) -> Result<Names, DiagnoseError> {
        let diverges = || DiagnoseError::TooLittle("the model diverges on the open rows".into());
        let rejection = self.rows.whole.settings.rejection;
        let chosen = self.found.best.hypothesis();
        let mut set = self.timed.map_or(chosen, |t| &t.set).clone();
        let mut refused = Vec::new();
        let mut alone = self.alone(&set);
        let mut barred = Vec::new();
        loop {
            let fit = self.rows.learn_beside(&set).ok_or_else(diverges)?;
            let problem = &self.rows.whole;
            let (base, best) = parallel::join(
                || problem.fit(problem.base(), problem.settings.search.iterations),
                || {
                    if set.members.is_empty() {
                        fit
                    } else {
                        moved_in_time(problem, multi_start(problem, fit))
                    }
                },
            );
            let base = base?;
            if set.members.is_empty() {
                let causes = Vec::new();
                self.refuse_others(&set, &mut refused);
                return Ok(Names { best: base.clone(), base, causes, refused });
            }
            let mut causes = self.causes(&base, &best)?;
            let rejected = |(place, c): (usize, &Cause)| {
                let why = if c.may_be_absent {
                    Rejection::MayBeAbsent
                } else if vague(problem, c) {
                    Rejection::ScaleUndetermined
                } else if c.mimics(&rejection) {
                    Rejection::Mimics
                } else {
                    return None;
                };
                Some((place, why))
            };
            // One at a time, and the least of them: without it the intervals of the others may be narrow enough.
            let share = |place: usize| causes[place].share_of_error_removed;
            let refuted = causes.iter().enumerate().filter_map(rejected);
            let least = refuted.min_by(|a, b| share(a.0).total_cmp(&share(b.0)));
            if let Some((place, why)) = least {
                let Cause { effect, inclusion, .. } = causes.swap_remove(place);
                refused.push(Refused { effect, inclusion, reason: why.reason().into() });
                barred.push(best.hypothesis.members[place].candidate);
                set = best.hypothesis.without(place);
                if let ([last], Some(better)) = (best.hypothesis.members.as_slice(), alone.take())
                    && !better.contains(last.candidate)
                {
                    let id = problem.system.candidate(better.members[0].candidate).id;
                    refused.retain(|r: &Refused| r.effect != id);
                    set = better;
                } else if set.members.is_empty() {
                    set = self.rival(&barred).unwrap_or(set);
                } else if why == Rejection::ScaleUndetermined {
                    set = self.rival_beside(&set, &barred).unwrap_or(set);
                }
                continue;
            }
            let names = Hypothesis { members: best.hypothesis.members.clone(), ..set };
            self.refuse_others(&names, &mut refused);
            self.mark_minor(&mut causes, &base, &best);
            causes.sort_by(|a, b| {
                let share = b.share_of_error_removed.total_cmp(&a.share_of_error_removed);
                a.minor.cmp(&b.minor).then(share)
            });
            return Ok(Names { base, best, causes, refused });
        }
    }

    /// The best member of a set of several alone, as the search has fitted it: where members imitate each other, each may seem absent
    /// beside the others, and the last one that is left need not be the right one.
    fn alone(&self, set: &Hypothesis) -> Option<Hypothesis> {
        if self.timed.is_some() || set.members.len() < 2 {
            return None;
        }
        let mut singles = self.found.singles.iter().map(Scored::hypothesis);
        singles.find(|h| h.members.iter().all(|m| set.contains(m.candidate))).cloned()
    }

    /// The most probable set without the refused candidates that has no more members than the chosen set; `None` if the odds of the
    /// chosen set against it are decisive.
    fn rival(&self, barred: &[usize]) -> Option<Hypothesis> {
        let limit = self.rows.whole.settings.verdict.confusable_odds.ln();
        let best = self.best_without(barred, |h| !h.members.is_empty())?;
        (self.found.best.log_odds(best) < limit).then(|| best.hypothesis().clone())
    }

    /// The most probable set without the refused candidates that adds causes to the `rest`; `None` if its odds against the rest are too low
    /// for a further cause. A rejected cause with an undetermined scale removes an error all the same, and a cause without that scale, such
    /// as Coulomb instead of Stribeck friction, may remove it as well.
    fn rival_beside(&self, rest: &Hypothesis, barred: &[usize]) -> Option<Hypothesis> {
        let is_larger = |h: &Hypothesis| {
            h.members.len() > rest.members.len()
                && rest.members.iter().all(|m| h.contains(m.candidate))
        };
        let best = self.best_without(barred, is_larger)?;
        let iterations = self.rows.whole.settings.search.iterations;
        // `rest` was fitted to training and validation recordings.
        let rest = self.rows.choosing.train.with_base_locals(rest);
        let fitted = |h: &Hypothesis| self.rows.fitted(h.clone(), iterations);
        let (best, rest) = parallel::join(|| fitted(best.hypothesis()), || fitted(&rest));
        let best = best?;
        (best.log_odds(&rest?) > self.rows.needed_log_odds()).then(|| best.hypothesis().clone())
    }

    /// The most probable set of the search without the refused candidates, with no more members than the chosen set, for which a
    /// condition holds; `None` beside causes that begin or end.
    fn best_without(
        &self,
        barred: &[usize],
        holds: impl Fn(&Hypothesis) -> bool,
    ) -> Option<&Scored> {
        if self.timed.is_some() {
            return None;
        }
        let chosen = &self.found.best;
        let may = |s: &&Scored| {
            s.members() <= chosen.members()
                && barred.iter().all(|&c| !s.hypothesis().contains(c))
                && holds(s.hypothesis())
        };
        let all = self.found.others.iter().filter(may);
        all.max_by(|a, b| a.log_odds(chosen).total_cmp(&b.log_odds(chosen)))
    }

    /// Normalised χ² with the prior cost of the nuisances, which may have taken a part of the error.
    pub(super) fn chi_square(&self, fit: &Fit) -> f64 {
        let rows = (fit.errors.rows * fit.errors.sums.len()).max(1) as f64;
        fit.errors.chi_square() + self.rows.whole.prior_cost(&fit.hypothesis) / rows
    }

    /// Marks causes that remove next to nothing, and further ones that may be there by chance.
    fn mark_minor(&self, causes: &mut [Cause], base: &Fit, best: &Fit) {
        let settings = &self.rows.whole.settings.verdict;
        let sum = |f: &Fit| self.chi_square(f);
        let removed = 1.0 - sum(best) / sum(base).max(f64::MIN_POSITIVE);
        // Starts and masses may have taken what the causes are: a small part of the residual, and far from their priors.
        let strain = |f: &Fit| self.rows.whole.prior_strain(&f.hypothesis);
        let relieved = strain(base) > 1.0 && strain(best) < 1.0;
        let all_minor = removed < settings.minor_of_residual && !relieved;
        // That there is something at all, the null test of the search has shown.
        let largest = causes.iter().map(|c| c.share_of_error_removed).fold(0.0, f64::max);
        for cause in causes {
            let little = all_minor || cause.share_of_error_removed < settings.minor_share;
            // Without a bias of a pressure the sealed masses take its trace: the error stays, but they cannot be so.
            let needed = cause.strain_without > STRAINED && strain(best) < 1.0;
            let infos = self.rows.whole.system.candidate(cause.member.candidate).parameters;
            let certain = cause.rise_without > AS_LARGE_AS_NOISE
                && cause.distance_from_absence(infos) > settings.certain_ratio;
            let negligible = cause.share_of_error_removed < settings.negligible_share && !certain;
            let unseen = little && cause.rise_without < settings.minor_rise;
            let beside = cause.share_of_error_removed < largest;
            let of_larger = beside && cause.rise_without < settings.minor_rise_beside;
            let by_chance = beside && cause.may_be_chance && cause.rise_without < AS_LARGE_AS_NOISE;
            cause.minor = (negligible || unseen || of_larger || by_chance) && !needed;
        }
    }
}

/// The largest rise of a channel's whitened mean square from one fit to another.
pub(crate) fn largest_rise(from: &Fit, to: &Fit) -> f64 {
    let rises = to.errors.mean().into_iter().zip(from.errors.mean()).map(|(t, f)| t - f);
    rises.fold(0.0, f64::max)
}
