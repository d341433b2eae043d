//! From a chosen set to names that stand.

use super::apparent::Apparent;
use super::cause::{Alternative, Cause, Refused};
use super::discrepancy::{ModelErrors, known_errors};
use super::outcome::share;
use crate::error::DiagnoseError;
use crate::fit::{Fit, HALF_WIDTH, Hypothesis, Interval, Member, Problem};
use crate::onset::{Pattern, TimedSet, Times, moved_in_time, time_interval};
use crate::rejection::{OF_INTERVALS, ParameterStability, StabilityTest, may_be_absent, vague};
use crate::search::refit::{multi_start, other_shapes};
use crate::search::{Candidates, Findings, Rows, Scored};
use pam_core::parallel;
use pam_numerics::dot;
use pam_vocabulary::ParameterInfo;

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
        let fitted = |h: &Hypothesis| self.rows.fitted(h.clone(), iterations);
        let (best, rest) = parallel::join(|| fitted(best.hypothesis()), || fitted(rest));
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
    fn chi_square(&self, fit: &Fit) -> f64 {
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
            let by_chance = cause.may_be_chance
                && cause.share_of_error_removed < largest
                && cause.rise_without < AS_LARGE_AS_NOISE;
            cause.minor = (negligible || unseen || by_chance) && !needed;
        }
    }

    /// The causes of a fitted set.
    fn causes(&self, base: &Fit, best: &Fit) -> Result<Vec<Cause>, DiagnoseError> {
        let problem = &self.rows.whole;
        let intervals = problem.intervals(best)?;
        let influences = problem.influences(best)?;
        let of_model = known_errors(problem, best);
        let (named, from) = (self.chi_square(best), self.chi_square(base));
        // Only the share of the error is read of these fits.
        let iterations = problem.settings.search.tried_iterations;
        let inclusion = self.inclusion();
        let members = &best.hypothesis.members;
        // Where the fitted values of each member begin.
        let lens = members.iter().map(|m| m.fitted(problem.system).len());
        let firsts: Vec<usize> = lens
            .scan(0, |next, len| {
                *next += len;
                Some(*next - len)
            })
            .collect();
        Ok(parallel::map(members.len(), |place| {
            let (member, first) = (&members[place], firsts[place]);
            let info = problem.system.candidate(member.candidate);
            let (own_len, len) = (info.parameters.len(), member.fitted(problem.system).len());
            let mut all: Vec<Interval> = intervals[first..first + len].to_vec();
            for (k, interval) in all[own_len..].iter_mut().enumerate() {
                interval.ci95 = time_interval(problem, best, place, k);
            }
            let (own, times) = all.split_at(own_len);
            let fitted = first..first + own_len;
            let stability = ParameterStability::of(problem, &best.hypothesis, place, own);
            let apparent = Apparent::of(self.baseline, member, info.parameters, problem.len());
            let parts = stability.as_ref().map_or(&[][..], |s| &s.half_widths);
            let errors = Errors { model: &of_model, first: fitted.start, parts };
            let mut parameters = widened(problem, (best, place), own, &errors, &apparent);
            let values: Vec<Interval> = parameters.iter().map(|p| p.1).collect();
            let of_rows = (own, &influences.values[fitted.clone()]);
            let may_be_absent = |probability: f64| {
                may_be_absent(
                    info.parameters.iter().zip(values.iter().copied()),
                    |i, j| errors.covariance(of_rows, i, j),
                    |weights| apparent.half_width_of(weights),
                    probability,
                )
            };
            let level = 1.0 - problem.settings.rejection.null_quantile;
            let choices = problem.system.candidate_len().max(1) as f64;
            let may_be_chance = may_be_absent(1.0 - level / choices);
            let may_be_absent = may_be_absent(OF_INTERVALS);
            let acts = Times::of(problem.system, &self.experiments(), member, times);
            if member.schedule.as_ref().is_some_and(|s| s.pattern != Pattern::Each) {
                let names = member.schedule.iter().flat_map(|s| &s.times).map(|p| p.name);
                parameters.extend(names.zip(times.iter().copied()));
            }
            let less = match best.hypothesis.members.len() {
                1 => Some(base.clone()),
                _ => problem.fit(best.hypothesis.without(place), iterations).ok(),
            };
            let without = less.as_ref().map_or(named, |f| self.chi_square(f));
            let alternatives = self.alternatives(best, place);
            let id = |c: usize| problem.system.candidate(c).id.to_owned();
            let limits = member.fitted(problem.system).into_iter().map(|(_, p)| p.name);
            Cause {
                effect: info.id.to_owned(),
                description: info.description.to_owned(),
                parameters,
                share_of_error_removed: share(without, named, without - (from - named.min(1.0))),
                rise_without: less.as_ref().map_or(0.0, |f| largest_rise(best, f)),
                strain_without: less.map_or(0.0, |f| problem.prior_strain(&f.hypothesis)),
                minor: false,
                may_be_absent,
                may_be_chance,
                inclusion: inclusion[member.candidate],
                confusable_with: alternatives.iter().map(|a| id(a.candidate)).collect(),
                alternatives_by_name: alternatives
                    .iter()
                    .map(|a| {
                        let infos = problem.system.candidate(a.candidate).parameters;
                        let values = infos.iter().zip(a.own());
                        Alternative {
                            effect: id(a.candidate),
                            values: values.map(|(p, v)| (p.name.to_owned(), *v)).collect(),
                        }
                    })
                    .collect(),
                alternatives,
                at_limit: limits.filter(|p| best.at_limit.contains(p)).collect(),
                excited_by: info.excited_by.to_owned(),
                stability,
                stability_test: StabilityTest::of(problem, best, &influences, fitted),
                acts,
                member: member.clone(),
            }
        }))
    }

    /// Candidates that explain nearly as much in place of a member of the chosen set: sets with another candidate in its
    /// place against which the odds are not enough, or that remove nearly as much of the error, so that a model that is not
    /// quite right may have decided between them.
    fn alternatives(&self, best: &Fit, place: usize) -> Vec<Member> {
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
        near.filter_map(|(h, _)| h.members.iter().find(|m| !best.contains(m.candidate)).cloned())
            .collect()
    }

    /// The experiments of the system.
    fn experiments(&self) -> Vec<usize> {
        (0..self.rows.whole.system.experiment_len()).collect()
    }

    /// The posterior probability that each candidate is at work, over the sets that were fitted in the last round, by
    /// their totals (Hoeting and others 1999).
    fn inclusion(&self) -> Vec<f64> {
        let count = self.rows.whole.system.candidate_len();
        if let Some(timed) = self.timed {
            let least = timed.others.first().map_or(0.0, |s| s.1);
            let odds = |s: &(Hypothesis, f64)| (0.5 * (least - s.1)).exp();
            let all: f64 = timed.others.iter().map(odds).sum();
            let of = |c: usize| {
                let with = timed.others.iter().filter(|(h, _)| h.contains(c));
                with.map(odds).sum::<f64>() / all.max(f64::MIN_POSITIVE)
            };
            return (0..count).map(of).collect();
        }
        let best = &self.found.best;
        let odds: Vec<f64> =
            self.found.others.iter().map(|s| (-best.log_odds(s)).min(0.0).exp()).collect();
        let all: f64 = odds.iter().sum();
        let of = |c: usize| {
            let sets = self.found.others.iter().zip(&odds);
            sets.filter(|(s, _)| s.hypothesis().contains(c)).map(|(_, o)| o).sum::<f64>()
        };
        (0..count).map(|c| if all > 0.0 { of(c) / all } else { 0.0 }).collect()
    }

    /// Lists every candidate that is neither named nor refused yet.
    fn refuse_others(&self, named: &Hypothesis, refused: &mut Vec<Refused>) {
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

/// What adds to the scatter of the residuals in the parameters of a cause.
struct Errors<'e> {
    /// Errors of the model that repeat with the motion.
    model: &'e ModelErrors,
    /// The place of the cause's first parameter among those that they move.
    first: usize,
    /// Half the 95 % intervals by values that change from part to part; none for too few parts.
    parts: &'e [f64],
}

impl Errors<'_> {
    fn of_parts(&self, parameter: usize) -> f64 {
        self.parts.get(parameter).copied().unwrap_or(0.0)
    }

    fn half_width(&self, parameter: usize) -> f64 {
        self.of_parts(parameter).hypot(self.model.half_width(self.first + parameter))
    }

    /// The covariance of two parameters, with that by the scatter of the residuals: their own intervals, correlated as the influences
    /// of the blocks are.
    fn covariance(&self, (own, influences): (&[Interval], &[Vec<f64>]), i: usize, j: usize) -> f64 {
        let product = |i: usize, j: usize| dot(&influences[i], &influences[j]);
        let size = (product(i, i) * product(j, j)).sqrt().max(f64::MIN_POSITIVE);
        let of_parts = if i == j { (self.of_parts(i) / HALF_WIDTH).powi(2) } else { 0.0 };
        product(i, j) / size * own[i].deviation() * own[j].deviation()
            + self.model.covariance(self.first + i, self.first + j)
            + of_parts
    }
}

/// The intervals of a cause's parameters, widened by errors that the scatter of the residuals does not show, by the apparent values on
/// baseline recordings, and by other shapes of the same cause that fit equally well, whose values are as uncertain. No limit leaves the
/// range of its parameter.
fn widened<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    (best, place): (&Fit, usize),
    own: &[Interval],
    errors: &Errors<'_>,
    apparent: &Apparent,
) -> Vec<(&'static str, Interval)> {
    let infos = problem.system.candidate(best.hypothesis.members[place].candidate).parameters;
    let widen = |(k, (interval, info)): (usize, (&Interval, &ParameterInfo))| {
        interval.widened(errors.half_width(k).hypot(apparent.half_width(k)), *info)
    };
    let mut intervals: Vec<Interval> = own.iter().zip(infos).enumerate().map(widen).collect();
    let of_named = intervals.clone();
    for shape in other_shapes(problem, best, place) {
        for ((interval, named), (value, info)) in
            intervals.iter_mut().zip(&of_named).zip(shape.into_iter().zip(infos))
        {
            let other = named.moved_to(value, *info);
            interval.ci95[0] = interval.ci95[0].min(other.ci95[0]);
            interval.ci95[1] = interval.ci95[1].max(other.ci95[1]);
        }
    }
    for (interval, info) in intervals.iter_mut().zip(infos) {
        interval.ci95 = interval.ci95.map(|end| end.clamp(info.range[0], info.range[1]));
    }
    infos.iter().map(|p| p.name).zip(intervals).collect()
}

/// The largest rise of a channel's whitened mean square from one fit to another.
pub(crate) fn largest_rise(from: &Fit, to: &Fit) -> f64 {
    let rises = to.errors.mean().into_iter().zip(from.errors.mean()).map(|(t, f)| t - f);
    rises.fold(0.0, f64::max)
}
