//! The fit of a smooth correction: where it acts, with which terms and which prior.

use super::basis::{remembering, smooth, waves};
use super::ground::Ground;
use super::learned::{Before, Learned, fitted};
use super::sparse::{grown, sparse};
use crate::error::DiagnoseError;
use crate::terms::{Term, TermSpace};
use pam_core::parallel;
use std::sync::{Mutex, PoisonError};

/// The corrections are fitted again if the residual of the best of them is correlated over less than this share of the rows that had
/// counted as one observation.
const FEWER_ROWS: f64 = 0.8;
/// Most times that they are.
const AGAIN: usize = 3;
/// Families whose correction is cut down before one of them is chosen.
const CUT_DOWN: usize = 2;

/// Learns a correction: at the places where it removes most of the error of the validation rows, with the prior that does, and
/// with memory or at further places where that is worth it. `None` if there is nothing to learn.
pub(crate) fn learn(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    done: &(dyn Fn(f64) + Sync),
) -> Result<Option<Learned>, DiagnoseError> {
    let (variables, places) = (space.variables(), space.places());
    let Some(mut before) = Before::of(space, ground)? else { return Ok(None) };
    let mut families: Vec<usize> = places.iter().map(|p| p.family).collect();
    families.sort_unstable();
    families.dedup();
    let mut alone = each_family(space, &before, &families, &|share| done(0.3 * share))?;
    // A slow error is few observations beside the causes, and many beside what explains it.
    for _ in 0..AGAIN {
        let best = alone.iter().min_by(|a, b| a.1.validation.total_cmp(&b.1.validation));
        let Some((_, best)) = best.filter(|_| !ground.budget.is_spent()) else { break };
        let rows = best.correlated_rows(space, ground)?;
        if rows > FEWER_ROWS * before.rows_per_observation {
            break;
        }
        before.rows_per_observation = rows;
        alone = each_family(space, &before, &families, &|share| done(0.3 + 0.3 * share))?;
    }
    let before = &before;
    // What the validation rows confirm comes before what is a little more probable and confirmed by none.
    let rank = |found: &Learned| (!found.is_learned(ground), found.validation);
    let best = alone.iter().min_by(|a, b| {
        let ((a, cost_a), (b, cost_b)) = (rank(&a.1), rank(&b.1));
        a.cmp(&b).then(cost_a.total_cmp(&cost_b))
    });
    let Some((family, mut best)) = best.cloned() else { return Ok(None) };
    if !ground.budget.is_spent() {
        best = with_best_deviation(space, before, best)?;
    }
    best = sparse(space, before, best)?;
    done(0.8);
    // What remembers or repeats may be all that there is: then no smooth terms tell where it acts. What remembers at one place may
    // imitate what remembers at another one, which then is tried by itself.
    let any_learned = best.is_learned(ground);
    let others = alone.iter().filter(|(k, _)| *k != family);
    let others = others.map(|(k, smooth)| (*k, (!any_learned).then(|| smooth.clone())));
    let starts: Vec<(usize, Option<Learned>)> =
        [(family, Some(best.clone()))].into_iter().chain(others).collect();
    let mut family = family;
    for (own, start) in starts {
        if best.is_enough(ground) || ground.budget.is_spent() {
            break;
        }
        let start = match start {
            Some(start) => start,
            None => {
                let iterations = ground.settings.remainder.iterations;
                let nothing = fitted(space, before, &[], best.deviation, None, iterations)?;
                let Some(nothing) = nothing else { break };
                nothing
            }
        };
        let mut more = remembering(own, variables, places);
        more.extend(waves(own, variables, places, &start.periods_left_s(space, ground)?));
        if more.is_empty() {
            continue;
        }
        let found = grown(space, before, start, more)?;
        if (!found.is_learned(ground), found.validation)
            < (!best.is_learned(ground), best.validation)
        {
            (family, best) = (own, found);
        }
    }
    done(0.9);
    for (other, found) in &alone {
        // Only what helps by itself helps beside something else.
        let helps = found.is_learned(ground);
        if *other == family || !helps || best.is_enough(ground) || ground.budget.is_spent() {
            continue;
        }
        best = grown(space, before, best, smooth(*other, variables, places))?;
    }
    done(1.0);
    Ok(best.is_learned(ground).then_some(best))
}

/// The correction at the places of each family alone, those that leave least of the training rows first and cut down.
fn each_family(
    space: &dyn TermSpace,
    before: &Before<'_>,
    families: &[usize],
    done: &(dyn Fn(f64) + Sync),
) -> Result<Vec<(usize, Learned)>, DiagnoseError> {
    let settings = &before.ground.settings.remainder;
    let finished = Mutex::new(0);
    let each: Result<Vec<Option<Learned>>, DiagnoseError> = parallel::map(families.len(), |k| {
        let terms = smooth_of(families[k], space);
        let (deviation, iterations) = (settings.deviations[0], settings.iterations);
        let found = fitted(space, before, &terms, deviation, None, iterations);
        // Reported under the lock, so that progress never goes back.
        let mut finished = finished.lock().unwrap_or_else(PoisonError::into_inner);
        *finished += 1;
        done(f64::from(*finished) / families.len() as f64);
        found
    })
    .into_iter()
    .collect();
    let found = families.iter().zip(each?);
    let mut alone: Vec<(usize, Learned)> =
        found.filter_map(|(family, found)| Some((*family, found?))).collect();
    // Many terms that remove the error of the training rows may go astray in validation rows that reach further: what removes
    // most there is judged by the few terms that do it as well.
    alone.sort_by(|a, b| a.1.train.total_cmp(&b.1.train));
    let cut =
        parallel::map(alone.len().min(CUT_DOWN), |k| sparse(space, before, alone[k].1.clone()));
    for ((_, found), few) in alone.iter_mut().zip(cut) {
        *found = few?;
    }
    Ok(alone)
}

/// A correction with the standard deviation of the prior that suits the validation rows best: from the one that it has, wider and
/// wider ones as long as that is better, else narrower ones.
fn with_best_deviation(
    space: &dyn TermSpace,
    before: &Before<'_>,
    mut best: Learned,
) -> Result<Learned, DiagnoseError> {
    let settings = &before.ground.settings.remainder;
    let first = best.deviation;
    let mut wider: Vec<f64> = settings.deviations.into_iter().filter(|d| *d > first).collect();
    let mut narrower: Vec<f64> = settings.deviations.into_iter().filter(|d| *d < first).collect();
    wider.sort_by(f64::total_cmp);
    narrower.sort_by(|a, b| b.total_cmp(a));
    for direction in [wider, narrower] {
        for deviation in direction {
            let found =
                fitted(space, before, &best.terms, deviation, Some(&best), settings.iterations)?;
            match found.filter(|f| f.validation < best.validation) {
                Some(better) => best = better,
                None => break,
            }
        }
        if best.deviation != first {
            break;
        }
    }
    Ok(best)
}

/// The smooth terms of each place of a family.
fn smooth_of(family: usize, space: &dyn TermSpace) -> Vec<Vec<Term>> {
    let terms = smooth(family, space.variables(), space.places());
    terms.chunk_by(|a, b| a.place == b.place).map(<[Term]>::to_vec).collect()
}

/// A correction at the same places beside fewer named causes, with what those were.
pub(crate) fn learn_again(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    known: &Learned,
) -> Result<Option<Learned>, DiagnoseError> {
    let (variables, places) = (space.variables(), space.places());
    let Some(mut before) = Before::of(space, ground)? else { return Ok(None) };
    before.rows_per_observation = before.rows_per_observation.min(known.rows_per_observation);
    let before = &before;
    let families = known.families(places);
    let terms: Vec<Vec<Term>> =
        families.iter().flat_map(|&family| smooth_of(family, space)).collect();
    let iterations = ground.settings.remainder.iterations;
    let Some(dense) = fitted(space, before, &terms, known.deviation, None, iterations)? else {
        return Ok(None);
    };
    let mut found = sparse(space, before, dense)?;
    for &family in &families {
        let mut more = remembering(family, variables, places);
        more.extend(waves(family, variables, places, &known.periods_s(variables)));
        let held = known.terms.iter().flatten().any(|t| more.contains(t));
        if held {
            found = grown(space, before, found, more)?;
        }
    }
    Ok(Some(found))
}
