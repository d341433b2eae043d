//! Fits of sets whose members begin or end.

use super::cells::cell_s;
use super::schedule::Pattern;
use crate::diagnosis::total;
use crate::fit::{Fit, Hypothesis, Problem};
use crate::search::{Candidates, fit_promising, stands};
use pam_core::parallel;

/// Fits sets to all open rows, and gives up those that can no longer become the best; the best first.
pub(super) fn fit_all<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    starts: Vec<Hypothesis>,
) -> Vec<Fit> {
    let price = |fit: &Fit| total(problem, fit);
    let mut done = fit_promising(problem, starts, price, (f64::INFINITY, 0.0));
    done.retain(|fit| {
        let h = &fit.hypothesis;
        stands(problem.system, h) && within(problem, h) && inside(problem.system, h)
    });
    done.sort_by(|a, b| price(a).total_cmp(&price(b)));
    done
}

/// Whether no own value of a timed member, and no ramp, is at a limit of its range, but where it is off: there the name stands
/// for something else.
fn inside<C: Candidates + ?Sized>(system: &C, h: &Hypothesis) -> bool {
    let timed = h.members.iter().filter(|m| m.schedule.is_some());
    timed.flat_map(|m| m.fitted(system).into_iter().map(move |f| (m, f))).all(|(m, (k, info))| {
        let (value, [low, high]) = (m.values[k], info.range);
        let margin = 1e-9 * (high - low);
        info.off == Some(value) || (value > low + margin && value < high - margin)
    })
}

/// Whether every onset and end lies strictly inside its recording. At the first or last sample, the effect would act throughout or never.
fn within<C: Candidates + ?Sized>(problem: &Problem<'_, C>, h: &Hypothesis) -> bool {
    h.members.iter().all(|m| {
        let Some(schedule) = &m.schedule else { return true };
        (0..problem.len()).all(|place| {
            let (e, window) = (problem.experiments[place], &problem.windows[place]);
            let ends = [window.start, window.end.max(1) - 1].map(|k| problem.system.time_s(e, k));
            let open = schedule.times_in(e).all(|t| {
                let scale = schedule.times[t].logarithmic;
                scale || (m.times()[t] > ends[0] && m.times()[t] < ends[1])
            });
            // With the same times everywhere, one recording that holds them is enough.
            open || schedule.pattern == Pattern::Shared && problem.len() > 1
        })
    })
}

/// Largest shift of a time that is tried, in cells.
const LARGEST_SHIFT: f64 = 1.5;
/// Distance of the shifts, in rows: the cost has valleys of a few rows, as a friction that begins while the joint moves has.
const SHIFT_ROWS: f64 = 2.0;
/// Valleys that are followed.
const VALLEYS: usize = 3;
/// Rounds of shifts.
const SHIFT_ROUNDS: usize = 2;

/// The fit from other times nearby: a time shows to first order only from within the response of the system.
pub(crate) fn moved_in_time<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    mut best: Fit,
) -> Fit {
    let settings = &problem.settings.search;
    let step_s = SHIFT_ROWS * problem.rows_s().fold(0.0, f64::max);
    let count = (LARGEST_SHIFT * cell_s(problem) / step_s).ceil() as i32;
    for _ in 0..SHIFT_ROUNDS {
        let mut valleys = Vec::new();
        for (place, member) in best.hypothesis.members.iter().enumerate() {
            let Some(schedule) = &member.schedule else { continue };
            for (k, info) in schedule.times.iter().enumerate().filter(|(_, i)| !i.logarithmic) {
                let at = member.own().len() + k;
                let shifted = |shift: i32| {
                    let mut other = best.hypothesis.clone();
                    let value = &mut other.members[place].values[at];
                    *value =
                        (*value + f64::from(shift) * step_s).clamp(info.range[0], info.range[1]);
                    other
                };
                let tried: Vec<Hypothesis> = (-count..=count).map(shifted).collect();
                let costs = parallel::map(tried.len(), |k| {
                    let h = &tried[k];
                    problem.errors(h).map_or(f64::INFINITY, |e| problem.cost(h, &e))
                });
                let inner = 1..tried.len() - 1;
                let lowest = |k: &usize| costs[*k] <= costs[k - 1] && costs[*k] < costs[k + 1];
                // The middle is where the fit is.
                let own = inner.filter(lowest).filter(|k| *k != count as usize);
                valleys.extend(own.map(|k| (costs[k], tried[k].clone())));
            }
        }
        valleys.sort_by(|a, b| a.0.total_cmp(&b.0));
        valleys.truncate(VALLEYS);
        let fitted = parallel::map_each(valleys, |(_, h)| {
            problem.fit_to(h, settings.tried_iterations, settings.converged_drop)
        });
        let better = fitted.into_iter().flatten().filter(|f| f.cost < best.cost - 1.0);
        let Some(next) = better.min_by(|a, b| a.cost.total_cmp(&b.cost)) else { break };
        best = problem.fit_further(next.clone(), settings.iterations).unwrap_or(next);
    }
    best
}
