//! Which terms a correction needs.

use super::ground::Dyn;
use super::learned::{Before, Learned, definitions, fitted};
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Member, Problem};
use crate::law::{Design, Scores};
use crate::terms::{Term, TermSpace, grouped};

/// Most terms of a correction that is cut down.
const MOST_TERMS: usize = 14;
/// Sums that are followed while it is.
const BEAM: usize = 3;
/// Drop of the validation cost that an addition to a correction must bring.
const WORTH: f64 = 10.0;

/// The few of the last `count` coefficients of a hypothesis that do most, to first order, about the residual beside the rest of it. Channels
/// are as good as noise where a fitted correction leaves them.
fn needed(
    train: &Problem<'_, Dyn<'_>>,
    hypothesis: &Hypothesis,
    count: usize,
    fitted: &Hypothesis,
) -> Result<Vec<usize>, DiagnoseError> {
    let design = Design::at(train, hypothesis)?;
    let first = design.own.len() - count;
    let design = design.beside(first);
    let scores = Scores {
        design: &design,
        rows_per_observation: train.correlated_rows(fitted)?,
        least: train.errors(fitted)?.mean(),
    };
    let sums = scores.beam(&design.own, &vec![0.0; count], MOST_TERMS, BEAM);
    Ok(sums.into_iter().next().map_or_else(Vec::new, |s| s.columns))
}

/// The correction without the terms that it does not need on the training rows, if the validation rows do not need them either:
/// it is known better where there are no data, and takes less time.
pub(super) fn sparse(
    space: &dyn TermSpace,
    before: &Before<'_>,
    dense: Learned,
) -> Result<Learned, DiagnoseError> {
    let ground = before.ground;
    let kept: Vec<usize> = space.with(&dense.definitions(space), |system| {
        let Some(rows) = ground.rows(system, &ground.start(system)) else { return Ok(Vec::new()) };
        let train = &rows.choosing.train;
        let count = dense.terms.iter().map(Vec::len).sum();
        needed(train, &dense.hypothesis, count, &dense.hypothesis)
    })?;
    if kept.is_empty() {
        return Ok(dense);
    }
    let (mut terms, mut members, mut first) = (Vec::new(), Vec::new(), 0);
    let (named, own) = dense.hypothesis.members.split_at(ground.named.len());
    for (all, member) in dense.terms.iter().zip(own) {
        let here = |k: &usize| (first..first + all.len()).contains(k);
        let of: Vec<usize> = kept.iter().copied().filter(here).map(|k| k - first).collect();
        first += all.len();
        if !of.is_empty() {
            terms.push(of.iter().map(|&k| all[k].clone()).collect::<Vec<Term>>());
            members.push(of.iter().map(|&k| member.values[k]).collect::<Vec<f64>>());
        }
    }
    let members = members
        .into_iter()
        .enumerate()
        .map(|(k, values)| Member::always(ground.listed + k, &values));
    let members = named.iter().cloned().chain(members).collect();
    let start =
        Learned { hypothesis: Hypothesis { members, ..dense.hypothesis.clone() }, ..dense.clone() };
    let iterations = 2 * ground.settings.remainder.iterations;
    let found = fitted(space, before, &terms, dense.deviation, Some(&start), iterations)?;
    Ok(found.filter(|f| f.validation < dense.validation + WORTH).unwrap_or(dense))
}

/// A correction with the few of some further terms that do most about what it leaves of the training rows, to first order; as it
/// was where the validation rows do not need them.
pub(super) fn grown(
    space: &dyn TermSpace,
    before: &Before<'_>,
    best: Learned,
    more: Vec<Term>,
) -> Result<Learned, DiagnoseError> {
    let ground = before.ground;
    let blocks: Vec<Vec<Term>> = grouped(&more).map(<[Term]>::to_vec).collect();
    let all = [best.terms.clone(), blocks.clone()].concat();
    let kept: Vec<usize> = space.with(&definitions(space, &all, best.deviation), |system| {
        let Some(rows) = ground.rows(system, &ground.start(system)) else { return Ok(Vec::new()) };
        let train = &rows.choosing.train;
        let first = ground.listed + best.terms.len();
        let with = blocks.iter().enumerate().fold(best.hypothesis.clone(), |h, (k, block)| {
            h.with(first + k, &vec![0.0; block.len()])
        });
        needed(train, &with, more.len(), &best.hypothesis)
    })?;
    if kept.is_empty() {
        return Ok(best);
    }
    let terms = kept.iter().map(|&k| more[k].clone()).collect();
    let terms = [best.terms.clone(), vec![terms]].concat();
    let iterations = ground.settings.remainder.iterations;
    let found = fitted(space, before, &terms, best.deviation, Some(&best), iterations)?;
    match found.filter(|f| f.validation < best.validation - WORTH) {
        Some(found) => sparse(space, before, found),
        None => Ok(best),
    }
}
