//! Local search: laws that differ in one factor from the best ones.

use super::find::WORTH;
use super::library::neighbours;
use super::refine::{Proposal, Tried, preferred, proposals, refine};
use crate::error::DiagnoseError;
use crate::remainder::Ground;
use crate::terms::{Term, TermSpace};

/// Most terms of a law whose neighbours are tried.
const VARIED: usize = 2;

/// Tries the neighbours of the best law of one term and of the preferred law, and repeats this while one of them improves. The
/// correction from which laws are screened, and the noise learned with it, may lack the right function or factor.
pub(super) fn vary(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    rows_per_observation: f64,
    (known, tried): (&mut Vec<Proposal>, &mut Vec<Tried>),
) -> Result<(), DiagnoseError> {
    let (variables, places) = (space.variables(), space.places());
    for _ in 0..=ground.settings.remainder.rounds {
        let one = tried.iter().find(|t| t.terms.len() == 1).cloned();
        let short = preferred(tried, ground).filter(|t| (2..=VARIED).contains(&t.terms.len()));
        let totals = |tried: &[Tried]| {
            let least = |t: Option<&Tried>| t.map_or(f64::INFINITY, |t| t.total);
            [least(tried.first()), least(tried.iter().find(|t| t.terms.len() == 1))]
        };
        let before = totals(tried);
        let bases = one.iter().chain(&short);
        let sets: Vec<Vec<Term>> =
            bases.flat_map(|t| neighbours(&t.terms, variables, places)).collect();
        let more = proposals(space, ground, &sets, known);
        tried.extend(refine(space, ground, &more, rows_per_observation)?);
        tried.sort_by(|a, b| a.total.total_cmp(&b.total));
        known.extend(more);
        if totals(tried).iter().zip(before).all(|(now, before)| *now >= before - WORTH) {
            break;
        }
    }
    Ok(())
}
