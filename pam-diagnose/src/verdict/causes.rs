//! The causes of a fitted set: values with intervals, evidence, and what else may be in their place.

use super::apparent::Apparent;
use super::cause::{Alternative, Cause};
use super::discrepancy::{ModelErrors, known_errors};
use super::naming::{Naming, largest_rise};
use super::outcome::share;
use crate::error::DiagnoseError;
use crate::fit::{Fit, HALF_WIDTH, Interval, Problem};
use crate::onset::{Pattern, Times, time_interval};
use crate::rejection::{
    OF_INTERVALS, ParameterStability, StabilityTest, is_absent_where_off, may_be_absent,
};
use crate::search::Candidates;
use crate::search::refit::other_shapes;
use pam_core::parallel;
use pam_numerics::dot;
use pam_numerics::statistics::chi_square_quantile;
use pam_vocabulary::ParameterInfo;

impl<C: Candidates + ?Sized> Naming<'_, '_, C> {
    /// The causes of a fitted set.
    pub(super) fn causes(&self, base: &Fit, best: &Fit) -> Result<Vec<Cause>, DiagnoseError> {
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
            let less = match best.hypothesis.members.len() {
                1 => Some(base.clone()),
                _ => problem.fit(best.hypothesis.without(place), iterations).ok(),
            };
            let is_absent_where_off = is_absent_where_off(problem, best, place);
            let gain = less.as_ref().map_or(f64::INFINITY, |f| f.cost - best.cost);
            let may_be_absent = |probability: f64| {
                if !is_absent_where_off {
                    return gain <= chi_square_quantile(probability, own_len as f64);
                }
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

    /// The experiments of the system.
    fn experiments(&self) -> Vec<usize> {
        (0..self.rows.whole.system.experiment_len()).collect()
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
