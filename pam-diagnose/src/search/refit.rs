//! The chosen set, fitted to training and validation data from several starts.

use super::candidates::Candidates;
use super::chosen::TIE;
use super::fits::stands;
use crate::fit::{Fit, Hypothesis, Problem};
use pam_core::parallel;

/// Refits a set from where it is, and from every starting value of each member: scales have several valleys.
pub(crate) fn multi_start<C: Candidates + ?Sized>(problem: &Problem<'_, C>, mut best: Fit) -> Fit {
    let settings = &problem.settings.search;
    let system = problem.system;
    let h = best.hypothesis.clone();
    let mut starts = Vec::new();
    for (place, member) in h.members.iter().enumerate() {
        let all = system.starts(member.candidate);
        let others = if all.len() > 1 { all } else { Vec::new() };
        starts.extend(others.into_iter().map(|own| with_own(&h, place, &own)));
    }
    let fitted = parallel::map_each(starts, |start| {
        problem.fit_to(start, settings.first_iterations, settings.converged_drop)
    });
    let mut going: Vec<Fit> = fitted.into_iter().flatten().collect();
    let mut iterations = settings.first_iterations;
    while !going.is_empty() {
        for fit in &going {
            if fit.cost < best.cost && stands(system, &fit.hypothesis) {
                best = fit.clone();
            }
        }
        going.retain(|fit| fit.may_reach() < best.cost - TIE && !fit.has_converged());
        going.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        if iterations >= settings.tried_iterations {
            going.truncate(settings.followed);
        }
        if iterations >= settings.multi_start_iterations {
            break;
        }
        iterations += settings.first_iterations;
        let go_on = |fit| problem.fit_further(fit, settings.first_iterations);
        going = parallel::map_each(going, go_on).into_iter().flatten().collect();
    }
    // To the very bottom of the best valley.
    problem.fit(best.hypothesis.clone(), settings.iterations).unwrap_or(best)
}

/// The hypothesis with other values of the member at `place`; its times stay.
fn with_own(h: &Hypothesis, place: usize, own: &[f64]) -> Hypothesis {
    let mut other = h.clone();
    other.members[place] = h.members[place].with_own(own);
    other
}

/// Values that the member at `place` takes in those of its other shapes (switches) that fit as well: within the cost
/// at which one parameter is worth it.
pub(crate) fn other_shapes<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    best: &Fit,
    place: usize,
) -> Vec<Vec<f64>> {
    let settings = &problem.settings.intervals;
    let fit = |start| problem.fit(start, settings.shape_iterations).ok();
    let fits = in_other_shapes(problem.system, &best.hypothesis, place).into_iter().filter_map(fit);
    fits.filter(|f| f.cost < best.cost + settings.equal_cost)
        .map(|f| f.hypothesis.members[place].values.clone())
        .collect()
}

/// A hypothesis with the member at `place` in each of its other shapes (switches), with the same parameters.
pub(super) fn in_other_shapes<C: Candidates + ?Sized>(
    system: &C,
    hypothesis: &Hypothesis,
    place: usize,
) -> Vec<Hypothesis> {
    let member = &hypothesis.members[place];
    let info = system.candidate(member.candidate);
    let switches = info.parameters.len()..info.value_len;
    let mut tried: Vec<Vec<f64>> = vec![member.values[switches.clone()].to_vec()];
    let mut found = Vec::new();
    for start in system.starts(member.candidate) {
        let shape = start[switches.clone()].to_vec();
        if tried.contains(&shape) {
            continue;
        }
        let mut own = member.own().to_vec();
        own[switches.clone()].copy_from_slice(&shape);
        tried.push(shape);
        found.push(with_own(hypothesis, place, &own));
    }
    found
}
