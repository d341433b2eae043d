//! Intervals of times by the profile likelihood.

use crate::fit::{Fit, Hypothesis, Problem};
use crate::search::Candidates;
use pam_core::parallel;
use pam_numerics::statistics::chi_square_quantile;
use std::sync::Arc;

/// First distance from a time at which the cost is looked at, in rows.
const FIRST_ROWS: f64 = 0.1;
/// Doublings of that distance.
const DOUBLINGS: usize = 16;
/// Halvings of the bracket.
const HALVINGS: usize = 4;
/// Iterations of the fit of all other values at each time.
const ITERATIONS: usize = 2;

/// The 95 % interval of a time of a member: where the cost, with all other values fitted anew, is by less than the quantile of
/// χ² above the least one.
pub(crate) fn time_interval<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    best: &Fit,
    member: usize,
    time: usize,
) -> [f64; 2] {
    let rise = chi_square_quantile(0.95, 1.0);
    let first = FIRST_ROWS * problem.rows_s().fold(f64::INFINITY, f64::min);
    let mut held = best.hypothesis.clone();
    let Some(schedule) = held.members[member].schedule.clone() else { return [f64::NAN; 2] };
    held.members[member].schedule = Some(Arc::new(schedule.held()));
    // A time of recordings that are not in the problem is not known from it.
    if problem.experiments.iter().all(|&e| !schedule.times_in(e).contains(&time)) {
        return schedule.times[time].range;
    }
    let at = held.members[member].own().len() + time;
    let (value, info) = (held.members[member].values[at], schedule.times[time]);
    let with = |time: f64| {
        let mut h: Hypothesis = held.clone();
        h.members[member].values[at] = time;
        h
    };
    // With all other values as they are, the cost is not below the profile.
    let bound = |time: f64| {
        let h = with(time);
        problem.errors(&h).map_or(f64::INFINITY, |e| problem.cost(&h, &e) - best.cost)
    };
    let profile = |time: f64| {
        problem.fit(with(time), ITERATIONS).map_or(f64::INFINITY, |f| f.cost - best.cost)
    };
    // A scale is looked at in its logarithm.
    let moved = |distance: f64| {
        let to = if info.logarithmic {
            value * (distance / value.max(first)).exp()
        } else {
            value + distance
        };
        to.clamp(info.range[0], info.range[1])
    };
    let side = |sign: f64| {
        let (mut inside, mut outside) = (0.0, sign * first);
        let beyond = |to: f64| to <= info.range[0] || to >= info.range[1];
        while bound(moved(outside)) < rise && !beyond(moved(outside)) {
            (inside, outside) = (outside, 2.0 * outside);
        }
        for _ in 0..DOUBLINGS {
            if profile(moved(outside)) > rise {
                break;
            }
            let to = moved(outside);
            if beyond(to) {
                return to;
            }
            (inside, outside) = (outside, 2.0 * outside);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            if profile(moved(middle)) > rise {
                outside = middle;
            } else {
                inside = middle;
            }
        }
        moved(outside)
    };
    parallel::join(|| side(-1.0), || side(1.0)).into()
}
