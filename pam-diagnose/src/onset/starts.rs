//! Sets of causes that an edge of the scan stands for.

use super::scan::{Edge, Scored};
use super::schedule::{Acts, Pattern, Schedule};
use crate::fit::{Hypothesis, Member, Problem};
use crate::search::Candidates;
use pam_vocabulary::ParameterInfo;
use pam_vocabulary::course::{ActivityWindow, END, ONSET};
use std::sync::Arc;

/// The schedule of an edge with its times, for all experiments of the system. Experiments that are not open go by their order,
/// or like all others; with times of their own they are there in the middle of the others' until they are fitted.
fn schedule<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    edge: &Edge,
    choices: f64,
) -> (Schedule, Vec<f64>) {
    let system = problem.system;
    let (course, time) =
        if edge.begins { (ActivityWindow::BEGINS, ONSET) } else { (ActivityWindow::ENDS, END) };
    let (before, behind) =
        if edge.begins { (Acts::Never, Acts::Always) } else { (Acts::Always, Acts::Never) };
    let count = system.experiment_len();
    let ended = |e: usize| system.time_s(e, system.points(e).max(1) - 1);
    let info = |e: usize| ParameterInfo { range: [0.0, ended(e)], ..time };
    let (mut times, mut values) = (Vec::new(), Vec::new());
    let mut acts = vec![Acts::Always; count];
    match edge.pattern {
        Pattern::Shared => {
            let latest = problem.experiments.iter().map(|&e| ended(e)).fold(0.0, f64::max);
            times.push(ParameterInfo { range: [0.0, latest], ..time });
            values.push(edge.times_s[0]);
            acts = vec![Acts::Within(course, 0); count];
        }
        Pattern::Once => {
            // The last experiment that is before the time as a whole.
            let last = |place: usize| edge.times_s[place] == f64::INFINITY;
            let boundary =
                (0..problem.len()).filter(|&i| last(i)).map(|i| problem.experiments[i]).max();
            for (e, acts) in acts.iter_mut().enumerate() {
                *acts = if boundary.is_some_and(|b| e <= b) { before } else { behind };
            }
            let within = (0..problem.len()).find(|&i| edge.times_s[i].is_finite());
            if let Some(place) = within {
                let e = problem.experiments[place];
                times.push(info(e));
                values.push(edge.times_s[place]);
                acts[e] = Acts::Within(course, 0);
                // What lies between the boundary and this experiment is before it as well.
                acts[..e].fill(before);
            }
        }
        Pattern::Each => {
            let finite = edge.times_s.iter().copied().filter(|t| t.is_finite());
            let middle = finite.clone().sum::<f64>() / finite.count().max(1) as f64;
            for (e, acts) in acts.iter_mut().enumerate() {
                let place = problem.experiments.iter().position(|&open| open == e);
                let time_s = place.map_or(middle, |place| edge.times_s[place]);
                *acts = if time_s == f64::INFINITY {
                    before
                } else if time_s == f64::NEG_INFINITY {
                    behind
                } else {
                    times.push(info(e));
                    values.push(time_s);
                    Acts::Within(course, times.len() - 1)
                };
            }
        }
    }
    let choices = choices.powi(if edge.pattern == Pattern::Each { values.len() as i32 } else { 1 });
    let schedule = Schedule { pattern: edge.pattern, acts, times, fitted: true, choices };
    (schedule, values)
}

/// The sets that an edge stands for.
pub(super) fn hypotheses<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    from: &Hypothesis,
    scored: &Scored,
    choices: f64,
) -> Vec<Hypothesis> {
    let (direction, edge) = (&scored.direction, &scored.edge);
    let member = |edge: &Edge| {
        let (schedule, times) = schedule(problem, edge, choices);
        Member {
            candidate: direction.candidate,
            values: [direction.values.as_slice(), &times].concat(),
            schedule: Some(Arc::new(schedule)),
            scales_held: false,
        }
    };
    let mut all = vec![from.with_member(member(edge))];
    if let Some(place) = direction.member {
        let ends = Edge { begins: false, ..edge.clone() };
        for edge in [edge, &ends] {
            let mut other = from.clone();
            other.members[place] = member(edge);
            all.push(other);
        }
    }
    all
}
