//! Names that have another value in each part of the data.

use crate::fit::{Hypothesis, Interval, Member, Problem, coordinate};
use crate::search::Candidates;
use pam_core::parallel;
use pam_numerics::statistics::t_quantile_95;
use serde::Serialize;
use std::ops::Range;
use std::sync::Arc;

/// One cause, fitted anew to parts of the recordings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterStability {
    /// Name of its parameter that is furthest from absent, in units of its interval.
    pub parameter: &'static str,
    /// Recording, start of the part (s), value there.
    pub parts: Vec<(String, f64, f64)>,
    /// Spread of the parts (half the distance of the quartiles) over the size of the common value.
    pub relative_spread: f64,
    /// Half the 95 % interval of each parameter's mean over the parts, in the coordinate in which it is fitted; zero
    /// for too few parts. It holds errors of the model that change from part to part, which the scatter of the
    /// residuals does not show.
    #[serde(skip)]
    pub half_widths: Vec<f64>,
}

impl ParameterStability {
    /// Fits the member at `place` of a fitted set anew to parts of each recording, none shorter than a block, with everything else as it is. A
    /// real cause has one value; a name that only mimics another cause has as many as there are parts.
    #[must_use]
    pub fn of<C: Candidates + ?Sized>(
        problem: &Problem<'_, C>,
        fitted: &Hypothesis,
        place: usize,
        intervals: &[Interval],
    ) -> Option<Self> {
        let settings = &problem.settings.rejection;
        let member = fitted.members.get(place)?;
        let infos = problem.system.candidate(member.candidate).parameters;
        // A cause of two sides may be at work on one of them only.
        let clear = |k: &usize| {
            let i = intervals.get(*k)?;
            let half = 0.5 * (i.ci95[1] - i.ci95[0]);
            Some((i.value - infos[*k].off.unwrap_or(0.0)).abs() / half.max(f64::MIN_POSITIVE))
        };
        let judged = (0..infos.len())
            .filter(|&k| !infos[k].logarithmic)
            .max_by(|a, b| clear(a).partial_cmp(&clear(b)).unwrap_or(std::cmp::Ordering::Equal))
            .unwrap_or(0);
        let info = *infos.get(judged)?;
        // The member goes to the end, where it alone is fitted, with its times as they are.
        let mut alone = fitted.without(place);
        alone.fixed = alone.members.len();
        let schedule = member.schedule.as_ref().map(|s| Arc::new(s.held()));
        let alone = alone.with_member(Member { schedule, ..member.clone() });
        // A part shorter than a block may hold no excitation of the cause, and one in which it does not act tells nothing.
        let blocks = |i: usize, points: usize| {
            let rows = points / problem.system.points_per_row();
            rows / problem.rows_per_block(i).max(1)
        };
        let places: Vec<(usize, Range<usize>)> = (0..problem.len())
            .flat_map(|i| {
                let whole = active(problem, member, i);
                let count = settings.stability_parts.min(blocks(i, whole.len())).max(1);
                // Whole rows of the experiment, whose sensitivities at the start serve all parts.
                let points = problem.system.points_per_row();
                let len = whole.len() / count / points * points;
                let parts = (0..count).map(move |part| whole.start + part * len);
                parts.filter(move |_| len > 0).map(move |from| (i, from..from + len))
            })
            .collect();
        parallel::for_each(problem.len(), &|i| {
            let (e, window) = (problem.experiments[i], problem.windows[i].clone());
            let _ = problem.system.sensitivities(&alone, &alone.locals[i], e, window);
        });
        let parts: Vec<(String, f64, Vec<f64>)> = parallel::map(places.len(), |k| {
            let (experiment, window) = places[k].clone();
            let from = window.start;
            let part = problem.part(experiment, window);
            let mut start = alone.clone();
            start.locals = vec![alone.locals[experiment].clone()];
            let fit = part.fit(start, settings.stability_iterations).ok()?;
            let e = part.experiments[0];
            let values = fit.hypothesis.members.last()?.values[..infos.len()].to_vec();
            let start_s = problem.system.time_s(e, from);
            Some((problem.system.name(e).to_owned(), start_s, values))
        })
        .into_iter()
        .flatten()
        .collect();
        let quartiles = |of: &dyn Fn(&[f64]) -> f64| {
            let mut values: Vec<f64> = parts.iter().map(|p| of(&p.2)).collect();
            values.sort_by(f64::total_cmp);
            let at = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
            at(0.75) - at(0.25)
        };
        let n = parts.len();
        let size = member.values[judged].abs().max(1e-12);
        let relative_spread = if n < settings.spread_fewest_parts {
            0.0
        } else {
            0.5 * quartiles(&|v| v[judged]) / size
        };
        let half_widths = infos
            .iter()
            .enumerate()
            .map(|(k, info)| {
                if n < settings.stability_fewest_parts {
                    return 0.0;
                }
                // Robust against parts in which the cause is hardly excited.
                let sd = quartiles(&|v| coordinate(v[k], *info)) / 1.349;
                t_quantile_95(n as f64 - 1.0) * sd / (n as f64).sqrt()
            })
            .collect();
        let parts = parts.into_iter().map(|(name, start, values)| (name, start, values[judged]));
        Some(Self { parameter: info.name, parts: parts.collect(), relative_spread, half_widths })
    }
}

/// The points of an experiment in which a member acts.
fn active<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    member: &Member,
    place: usize,
) -> Range<usize> {
    let (e, window) = (problem.experiments[place], problem.windows[place].clone());
    let Some(schedule) = &member.schedule else { return window };
    let Some([from_s, to_s]) = schedule.stretch_s(e, member.times()) else {
        return window.start..window.start;
    };
    let point = |s: f64| {
        if s == f64::INFINITY { window.end } else { problem.system.point_at(e, s.max(0.0)) }
    };
    let from = point(from_s).clamp(window.start, window.end);
    from..point(to_s).clamp(from, window.end)
}
