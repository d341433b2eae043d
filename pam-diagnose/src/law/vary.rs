//! Local search: laws that differ in one factor from the best ones.

use super::design::Design;
use super::find::{About, WORTH};
use super::neighbours::neighbours;
use super::refine::{Searched, Tried, preferred, refine, with_dry_variants};
use super::screen::{blocks, columns};
use super::select::Scores;
use crate::error::DiagnoseError;
use crate::fit::Hypothesis;
use crate::remainder::Ground;
use crate::terms::{Definition, Term, TermSpace};
use pam_core::parallel;

/// Most terms of a law whose neighbours are tried.
const VARIED: usize = 2;
/// Laws of one term without the named causes whose neighbours are tried, each with other variables or at another place. Those of
/// the best one that remembers are tried as well, and of the best one beside the named causes.
const BASES: usize = 2;
/// Neighbours of a law that are fitted in the place of one of its terms, and beside all of them.
const FITTED: [usize; 2] = [12, 6];

/// Tries the neighbours of the best laws of one term and of the preferred law, and repeats this while one of them improves. The
/// correction from which laws are screened, and the noise learned with it, may lack the right function or factor.
pub(super) fn vary(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    about: &About,
    searched: &mut Searched,
) -> Result<(), DiagnoseError> {
    let mut varied: Vec<Tried> = Vec::new();
    for _ in 0..=ground.settings.remainder.rounds {
        if ground.budget.is_spent() {
            break;
        }
        let totals = |tried: &[Tried]| {
            let least = |t: Option<&Tried>| t.map_or(f64::INFINITY, |t| t.total);
            [least(tried.first()), least(tried.iter().find(|t| t.terms.len() == 1))]
        };
        let before = totals(&searched.tried);
        let mut sets = Vec::new();
        for base in bases(&searched.tried, ground) {
            if !varied.iter().any(|v| v.is_like(&base)) {
                let found = screened(space, ground, about, &base)?;
                sets.extend(found.into_iter().map(|terms| (terms, base.named.clone())));
                varied.push(base);
            }
        }
        let more = with_dry_variants(space, sets, &searched.known);
        refine(space, ground, more, about.rows_per_observation, searched)?;
        if totals(&searched.tried).iter().zip(before).all(|(now, before)| *now >= before - WORTH) {
            break;
        }
    }
    Ok(())
}

/// The laws whose neighbours are tried.
fn bases(tried: &[Tried], ground: &Ground<'_>) -> Vec<Tried> {
    let mut bases: Vec<Tried> = Vec::new();
    let subject = |t: &Tried| (t.terms[0].place, t.terms[0].variables());
    let ones = || tried.iter().filter(|t| t.terms.len() == 1);
    let alone = || ones().filter(|t| t.named.is_empty());
    for one in alone() {
        if bases.len() < BASES && bases.iter().all(|b| subject(b) != subject(one)) {
            bases.push(one.clone());
        }
    }
    let more = [alone().find(|t| t.terms[0].remembers()), ones().find(|t| !t.named.is_empty())];
    for law in more.into_iter().flatten() {
        if !bases.iter().any(|b| b.is_like(law)) {
            bases.push(law.clone());
        }
    }
    let preferred = preferred(tried, ground).filter(|t| (2..=VARIED).contains(&t.terms.len()));
    bases.extend(preferred);
    bases
}

/// The neighbours of a law that leave least, to first order about the law.
fn screened(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    about: &About,
    law: &Tried,
) -> Result<Vec<Vec<Term>>, DiagnoseError> {
    let (variables, places) = (space.variables(), space.places());
    // The terms themselves, then the neighbours of each, in an order that keeps those of one kind together.
    let mut terms: Vec<(Option<usize>, Term)> =
        law.terms.iter().map(|t| (None, t.clone())).collect();
    for (k, term) in law.terms.iter().enumerate() {
        let mut own = neighbours(term, variables, places);
        own.sort_by_key(Term::remembers);
        terms.extend(own.into_iter().map(|t| (Some(k), t)));
    }
    let all: Vec<Term> = terms.iter().map(|t| t.1.clone()).collect();
    let mut definitions = vec![Definition::law("law", "", &law.terms, variables, places)];
    definitions.extend(blocks(space, &all));
    space.with(&definitions, |system| {
        let start = Hypothesis { members: law.named.clone(), ..ground.start(system) };
        let Some(mut rows) = ground.rows(system, &start) else { return Ok(Vec::new()) };
        let rows_per_observation = about.rows_per_observation;
        rows.set_rows_per_observation(rows_per_observation);
        let iterations = ground.settings.remainder.iterations;
        // A law that diverges somewhere has no neighbours.
        let Ok(fit) = law.fitted_to(&rows.whole, ground.listed, iterations) else {
            return Ok(Vec::new());
        };
        let design = Design::at(&rows.whole, &fit.hypothesis)?;
        let named = design.own.len() - law.values.len();
        let design = design.beside(named);
        let columns = columns((&rows.whole, &fit.hypothesis), &design, &all, ground.listed + 1);
        let least = vec![1.0; design.channels()];
        let scores = Scores { design: &design, rows_per_observation, least };
        let price = |t: &Term| 2.0 * t.description_length(variables, places);
        let prices: Vec<f64> = all.iter().map(price).collect();
        let solved = |set: Vec<usize>| {
            let found = scores.least_squares(&columns, &prices, &set)?;
            let with = |(&k, c): (&usize, &f64)| Term {
                coefficient: c * all[k].coefficient,
                ..all[k].clone()
            };
            let law = set.iter().zip(&found.coefficients).map(with).collect();
            Some((found.total, law))
        };
        let count = law.terms.len();
        let in_place = |k: usize| {
            let at = terms[k].0?;
            solved((0..count).map(|i| if i == at { k } else { i }).collect())
        };
        let beside = |k: usize| {
            terms[k].0.filter(|_| count < VARIED)?;
            solved((0..count).chain([k]).collect())
        };
        // What acts alike at two places, such as both pressure sensors, is varied at both together.
        let each = (all.len() - count) / count;
        let are_twins = count == 2 && law.terms[0].acts_like(&law.terms[1]);
        let at_both = |k: usize| {
            let is_first = are_twins && terms[k].0 == Some(0);
            if is_first { solved(vec![k, k + each]) } else { None }
        };
        let mut chosen = distinct(parallel::map(all.len(), in_place), FITTED[0]);
        chosen.extend(distinct(parallel::map(all.len(), at_both), FITTED[1]));
        chosen.extend(distinct(parallel::map(all.len(), beside), FITTED[1]));
        Ok(chosen)
    })
}

/// The most probable laws that differ in more than numbers, which are fitted.
fn distinct(found: Vec<Option<(f64, Vec<Term>)>>, most: usize) -> Vec<Vec<Term>> {
    let mut found: Vec<(f64, Vec<Term>)> = found.into_iter().flatten().collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut chosen: Vec<Vec<Term>> = Vec::new();
    for (_, law) in found {
        let is_known = |other: &Vec<Term>| other.iter().zip(&law).all(|(a, b)| a.is_like(b));
        if chosen.len() < most && !chosen.iter().any(is_known) {
            chosen.push(law);
        }
    }
    chosen
}
