//! The chosen set and its rivals, refitted to training and validation data from several starts.

use super::candidates::Candidates;
use super::extend::stands;
use super::forward::Findings;
use super::scored::{Scored, refit_without, score};
use crate::data::Split;
use crate::fit::Hypothesis;
use crate::rejection::insignificant;
use pam_core::parallel;

/// A set of candidates, as the search chose it and as all open experiments fit it.
#[derive(Debug, Clone)]
pub(crate) struct Refitted {
    /// Fitted to the training rows, chosen by the validation rows.
    pub(crate) chosen: Scored,
    /// The same set fitted to both.
    pub(crate) whole: Scored,
}

/// Refits the set that a search chose, and those that came close, to `whole`: training and validation rows. The cost
/// of dry friction is rugged in its parameters, and a set that was left in a poor valley must not lose by that, so the
/// best are refitted from several starts before one is taken. A larger set must be better by the drop of the total
/// cost for each further cause.
///
/// `None` if nothing was chosen, or no fit can be simulated.
#[must_use]
pub(crate) fn refit<C: Candidates + ?Sized>(
    whole: &Split<'_, C>,
    found: &Findings,
) -> Option<Refitted> {
    let settings = &whole.train.settings.search;
    if found.best.members() == 0 {
        return None;
    }
    let price = |s: &Scored| s.total + settings.total_drop * s.members() as f64;
    let bound = price(&found.best) + settings.rival_cost;
    let mut sets = vec![found.best.clone()];
    for other in &found.others {
        let set = other.hypothesis().set();
        let known = sets.iter().any(|s| s.hypothesis().set() == set);
        if price(other) < bound && sets.len() < settings.rivals && !known {
            sets.push(other.clone());
        }
    }
    let by_price = |a: &Refitted, b: &Refitted| price(&a.whole).total_cmp(&price(&b.whole));
    let mut fitted: Vec<Refitted> = parallel::map_each(sets, |chosen| {
        let locals = whole.train.base().locals;
        let start = Hypothesis { locals, ..chosen.hypothesis().clone() };
        let fit = whole.train.fit(start, settings.rival_iterations).ok()?;
        score(whole, fit).map(|whole| Refitted { chosen, whole })
    })
    .into_iter()
    .flatten()
    .collect();
    fitted.sort_by(by_price);
    let best = fitted.first().map(|s| price(&s.whole))?;
    fitted.retain(|s| price(&s.whole) < best + settings.rival_cost);
    fitted.truncate(settings.finalists);
    let mut refitted: Vec<Refitted> = fitted
        .into_iter()
        .map(|s| Refitted { whole: multi_start(whole, s.whole), chosen: s.chosen })
        .collect();
    refitted.sort_by(by_price);
    let sound = |s: &&Refitted| {
        stands(whole.train.system, s.whole.hypothesis())
            && insignificant(&whole.train, &s.whole.fit).is_none()
    };
    refitted.iter().find(sound).or(refitted.first()).cloned()
}

/// Both fits without the member at `place`.
#[must_use]
pub(crate) fn without<C: Candidates + ?Sized>(
    choosing: &Split<'_, C>,
    whole: &Split<'_, C>,
    set: &Refitted,
    place: usize,
) -> Option<Refitted> {
    let iterations = whole.train.settings.search.rejected_iterations;
    let chosen = refit_without(choosing, &set.chosen, place, iterations)?;
    refit_without(whole, &set.whole, place, iterations).map(|whole| Refitted { chosen, whole })
}

/// Refits a set from where it is, from every starting value of each member (scales have several valleys), and with
/// the parameters of a member with a rugged cost made smaller and larger.
fn multi_start<C: Candidates + ?Sized>(split: &Split<'_, C>, best: Scored) -> Scored {
    let settings = &split.train.settings.search;
    let system = split.train.system;
    let h = best.hypothesis();
    let mut starts = vec![h.clone()];
    for (place, member) in h.members.iter().enumerate() {
        let all = system.starts(member.candidate);
        if all.len() > 1 {
            starts.extend(all.into_iter().map(|values| with_values(h, place, values)));
        }
        let rugged = system.is_rugged(member.candidate, &member.values);
        let parameters = system.candidate(member.candidate).parameters.len();
        for k in 0..if rugged { parameters } else { 0 } {
            starts.extend(settings.rugged_factors.map(|factor| {
                let mut values = member.values.clone();
                values[k] *= factor;
                with_values(h, place, values)
            }));
        }
    }
    parallel::map_each(starts, |start| {
        let fit = split.train.fit(start, settings.multi_start_iterations).ok()?;
        stands(system, &fit.hypothesis).then(|| score(split, fit)).flatten()
    })
    .into_iter()
    .flatten()
    .fold(best, |best, other| if other.total < best.total { other } else { best })
}

fn with_values(h: &Hypothesis, place: usize, values: Vec<f64>) -> Hypothesis {
    let mut other = h.clone();
    other.members[place].values = values;
    other
}

/// Values that the member at `place` takes in those of its other shapes (switches) that fit as well: within the cost
/// at which one parameter is worth it.
#[must_use]
pub(crate) fn other_shapes<C: Candidates + ?Sized>(
    split: &Split<'_, C>,
    best: &Scored,
    place: usize,
) -> Vec<Vec<f64>> {
    let settings = &split.train.settings.intervals;
    let system = split.train.system;
    let member = &best.hypothesis().members[place];
    let info = system.candidate(member.candidate);
    let switches = info.parameters.len()..info.value_len;
    let mut tried: Vec<Vec<f64>> = vec![member.values[switches.clone()].to_vec()];
    let mut found = Vec::new();
    for start in system.starts(member.candidate) {
        let shape = start[switches.clone()].to_vec();
        if tried.contains(&shape) {
            continue;
        }
        tried.push(shape.clone());
        let mut values = member.values.clone();
        values[switches.clone()].copy_from_slice(&shape);
        let start = with_values(best.hypothesis(), place, values);
        let fit = split.train.fit(start, settings.shape_iterations).ok();
        let scored = fit.and_then(|fit| score(split, fit));
        if let Some(s) = scored.filter(|s| s.total < best.total + settings.equal_cost) {
            found.push(s.hypothesis().members[place].values.clone());
        }
    }
    found
}
