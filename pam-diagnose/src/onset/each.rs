//! Times that each experiment has of its own, in experiments that were not fitted.

use super::cells::cell_s;
use super::schedule::{Acts, Pattern};
use crate::fit::{Hypothesis, Problem};
use crate::search::Candidates;
use pam_core::parallel;

/// Narrowings of the interval around the best time.
const NARROWINGS: usize = 8;

/// The hypothesis with the times of the experiments of a problem, where each has its own: the values of the members say what
/// begins, an experiment by itself when. They are nuisances of the experiment, as its start is.
pub(crate) fn with_own_times<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    hypothesis: &Hypothesis,
) -> Hypothesis {
    let mut h = hypothesis.clone();
    for member in 0..h.members.len() {
        let Some(schedule) = h.members[member].schedule.clone() else { continue };
        if schedule.pattern != Pattern::Each {
            continue;
        }
        for (place, &e) in problem.experiments.iter().enumerate() {
            let Acts::Within(_, first) = schedule.acts[e] else { continue };
            let at = h.members[member].own().len() + first;
            let (system, window) = (problem.system, &problem.windows[place]);
            let [from_s, to_s] = [window.start, window.end.max(1) - 1].map(|k| system.time_s(e, k));
            let alone = problem.one(place);
            let cost = |time_s: f64| {
                let mut other = h.clone();
                other.locals = vec![h.locals[place].clone()];
                other.members[member].values[at] = time_s;
                alone.errors(&other).map_or(f64::INFINITY, |e| e.chi_square())
            };
            let mut step_s = cell_s(problem).min(to_s - from_s).max(f64::MIN_POSITIVE);
            let count = ((to_s - from_s) / step_s).ceil() as usize;
            let times: Vec<f64> =
                (0..=count).map(|k| (from_s + step_s * k as f64).min(to_s)).collect();
            let costs = parallel::map(times.len(), |k| cost(times[k]));
            let nearest = (0..times.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b]));
            let Some(nearest) = nearest else { continue };
            let (mut time_s, mut least) = (times[nearest], costs[nearest]);
            for _ in 0..NARROWINGS {
                step_s *= 0.5;
                for tried in [time_s - step_s, time_s + step_s] {
                    let reached = cost(tried);
                    if reached < least && (from_s..=to_s).contains(&tried) {
                        (time_s, least) = (tried, reached);
                    }
                }
            }
            h.members[member].values[at] = time_s;
        }
    }
    h
}
