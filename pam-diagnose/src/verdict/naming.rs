//! From a chosen set to names that stand, and the verdict.

use super::cause::{Cause, confusable};
use super::explainable::ExplainableReference;
use super::outcome::{ChiSquares, Verdict};
use crate::data::Split;
use crate::error::DiagnoseError;
use crate::fit::{Interval, Problem};
use crate::rejection::null_test::explained;
use crate::rejection::{NullTest, ParameterStability, may_be_absent};
use crate::search::refit::{self, Refitted, other_shapes};
use crate::search::{Candidates, Findings, Scored, refit_without};

/// Everything from which names follow.
pub(crate) struct Naming<'n, 'a, C: ?Sized> {
    /// Training rows, and the validation rows by which the search chose.
    pub(crate) choosing: &'n Split<'a, C>,
    /// Both together, all fitted.
    pub(crate) whole: &'n Split<'a, C>,
    /// The result of the search.
    pub(crate) found: &'n Findings,
    /// The base model on all open rows.
    pub(crate) base: &'n Scored,
    /// Baseline recordings, if they were given.
    pub(crate) baseline: Option<&'n Problem<'a, C>>,
    /// Seed of the null test.
    pub(crate) seed: u64,
}

/// Names with their verdict.
pub(crate) struct Named {
    pub(crate) verdict: Verdict,
    /// The largest share of the error first.
    pub(crate) causes: Vec<Cause>,
    /// The base model if nothing is named.
    pub(crate) best: Scored,
    pub(crate) null_test: Option<NullTest>,
}

impl<C: Candidates + ?Sized> Naming<'_, '_, C> {
    /// Refits the chosen set, rejects names that stand for something else, and weighs what is left.
    pub(crate) fn named(&self) -> Result<Named, DiagnoseError> {
        let problem = &self.whole.train;
        let rejection = &problem.settings.rejection;
        let mut set = refit::refit(self.whole, self.found);
        let mut causes = self.causes(set.as_ref())?;
        // A rejected name goes; the others are fitted again without it.
        let mut mimicked = false;
        let rejected = |c: &Cause| c.mimics(rejection) || self.absent(c);
        while let (Some(s), Some(place)) = (&set, causes.iter().position(rejected)) {
            mimicked |= causes[place].mimics(rejection) && !self.absent(&causes[place]);
            set = refit::without(self.choosing, self.whole, s, place)
                .filter(|less| less.whole.members() > 0);
            causes = self.causes(set.as_ref())?;
        }
        let mut null_test = {
            let named = set.as_ref().map_or(self.base, |s| &s.whole);
            NullTest::calibrate(problem, self.base, named, self.seed)
        };
        set = set.filter(|s| {
            let share = explained(problem, self.base, &s.whole);
            null_test.is_none_or(|test| share > test.of_set(s.whole.members()))
        });
        let mut verdict = self.verdict(set.as_ref());
        // A mimicked error is there all the same.
        if verdict == Verdict::NothingFound && mimicked {
            verdict = Verdict::Unexplained;
        }
        if verdict == Verdict::Unexplained {
            set = None;
        }
        let Some(set) = set else {
            let best = self.base.clone();
            return Ok(Named { verdict, causes: Vec::new(), best, null_test });
        };
        if let Some(test) = &mut null_test {
            test.named_share = explained(problem, self.base, &set.whole);
        }
        causes.sort_by(|a, b| b.share_of_error_removed.total_cmp(&a.share_of_error_removed));
        Ok(Named { verdict, causes, best: set.whole, null_test })
    }

    fn verdict(&self, set: Option<&Refitted>) -> Verdict {
        let (split, noise) = (self.choosing, &self.whole.train.noise);
        let base = self.base.chi_square(noise);
        let found = &self.found.base;
        let validation = found.validation.chi_square(noise);
        let here = split.on_validation(found.hypothesis());
        let reference = ExplainableReference::learn(
            (&split.train, found.hypothesis()),
            (&split.validation, &here),
        );
        let explainable = reference.map_or(1.0, |r| r.errors.chi_square(noise) / validation * base);
        let (named, causes) = match set {
            Some(s) => (s.whole.chi_square(noise), s.whole.members()),
            None => (base, 0),
        };
        let chi = ChiSquares { base, named, explainable: explainable.min(base) };
        Verdict::of(chi, causes, &self.whole.train.settings.verdict)
    }

    fn causes(&self, set: Option<&Refitted>) -> Result<Vec<Cause>, DiagnoseError> {
        let Some(set) = set else { return Ok(Vec::new()) };
        let best = &set.whole;
        let problem = &self.whole.train;
        let noise = &problem.noise;
        let mut intervals = problem.intervals(&best.fit)?.into_iter();
        let named = best.chi_square(noise);
        let base = self.base.chi_square(noise);
        let iterations = problem.settings.search.drop_iterations;
        let members = best.hypothesis().members.iter().enumerate();
        Ok(members
            .map(|(place, member)| {
                let info = problem.system.candidate(member.candidate);
                let own: Vec<Interval> = intervals.by_ref().take(info.parameters.len()).collect();
                let stability = ParameterStability::of(problem, best.hypothesis(), place);
                let parameters = self.widened(best, place, &own, stability.as_ref());
                let without = if best.members() == 1 {
                    base
                } else {
                    let less = refit_without(self.whole, best, place, iterations);
                    less.map_or(named, |s| s.chi_square(noise))
                };
                let removable = (base - named.min(1.0)).max(1e-9);
                let found = &self.found;
                let alternatives =
                    confusable(self.choosing, &found.base, &set.chosen, place, &found.singles);
                let id = |c: usize| problem.system.candidate(c).id.to_owned();
                Cause {
                    effect: info.id.to_owned(),
                    description: info.description.to_owned(),
                    parameters,
                    share_of_error_removed: ((without - named) / removable).clamp(0.0, 1.0),
                    confusable_with: alternatives.iter().map(|a| id(a.candidate)).collect(),
                    alternatives,
                    excited_by: info.excited_by.to_owned(),
                    stability,
                    member: member.clone(),
                }
            })
            .collect())
    }

    /// Whether the widened intervals hold that there is no such cause. The scatter of the residuals alone spoke for
    /// it, or it would not be in the set; errors of the model that change from part to part, or its apparent value on
    /// baseline recordings, are as large as it is.
    fn absent(&self, cause: &Cause) -> bool {
        let infos = self.whole.train.system.candidate(cause.member.candidate).parameters;
        may_be_absent(infos.iter().zip(cause.parameters.iter().map(|p| p.1)))
    }

    /// The intervals of a cause's parameters with what the scatter of the residuals does not show: errors of the model
    /// that change from part to part, the apparent value on baseline recordings, and other shapes of the same cause
    /// that fit as well.
    fn widened(
        &self,
        best: &Scored,
        place: usize,
        own: &[Interval],
        stability: Option<&ParameterStability>,
    ) -> Vec<(&'static str, Interval)> {
        let member = &best.hypothesis().members[place];
        let infos = self.whole.train.system.candidate(member.candidate).parameters;
        let apparent = self.apparent(member.candidate, &member.values);
        let mut intervals: Vec<Interval> = own
            .iter()
            .zip(infos)
            .enumerate()
            .map(|(k, (interval, info))| {
                let parts = stability.and_then(|c| c.half_widths.get(k)).copied().unwrap_or(0.0);
                let baseline = match (&apparent, info.off) {
                    (Some(seems), Some(off)) => 1.96 * (seems[k] - off).abs(),
                    _ => 0.0,
                };
                // A baseline recording cannot make more of a value than the value itself.
                interval.widened(parts.hypot(baseline.min(interval.value.abs())), *info)
            })
            .collect();
        for shape in other_shapes(self.whole, best, place) {
            for (interval, value) in intervals.iter_mut().zip(shape) {
                interval.ci95 = [interval.ci95[0].min(value), interval.ci95[1].max(value)];
            }
        }
        infos.iter().map(|p| p.name).zip(intervals).collect()
    }

    /// The values that a candidate takes on the baseline recordings, where it is absent; `None` without such
    /// recordings, or if it cannot be fitted there.
    fn apparent(&self, candidate: usize, values: &[f64]) -> Option<Vec<f64>> {
        let problem = self.baseline?;
        let start = problem.base().with(candidate, values);
        let fit = problem.fit(start, problem.settings.intervals.baseline_iterations).ok()?;
        fit.hypothesis.members.last().map(|m| m.values.clone())
    }
}
