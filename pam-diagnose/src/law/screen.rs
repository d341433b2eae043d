//! Screening: the linearised effect of the terms of a library, and the short sums of terms that explain most of the residual.

use super::design::{Design, orthonormal};
use super::select::{OWN_SHARE, Scores};
use crate::fit::{Hypothesis, Problem};
use crate::remainder::{Dyn, Ground};
use crate::terms::{Definition, Term, TermSpace, grouped};
use pam_numerics::dot;

/// Terms of the library that are screened again about a law.
const SCREENED_AGAIN: usize = 160;

/// Sensitivities to terms at a hypothesis, and the residual there.
pub(super) struct Screened {
    pub(super) target: Vec<f64>,
    pub(super) columns: Vec<Vec<f64>>,
}

impl Screened {
    /// The terms of a library that explain most of the residual of a law, to first order.
    pub(super) fn beside(&self, law: &[Term], library: &[Term]) -> Vec<Term> {
        let like = |k: &usize| law.iter().any(|t| t.is_like(&library[*k]));
        let own = (0..library.len()).filter(like).map(|k| self.columns[k].clone()).collect();
        let basis = orthonormal(own);
        let cleared = |column: &[f64]| {
            let mut left = column.to_vec();
            for b in &basis {
                let share = dot(b, &left);
                left.iter_mut().zip(b).for_each(|(l, b)| *l -= share * b);
            }
            left
        };
        let left = cleared(&self.target);
        let gain = |column: &Vec<f64>| {
            let (size, own) = (dot(column, column), cleared(column));
            let own_size = dot(&own, &own);
            if own_size > OWN_SHARE * size { dot(&own, &left).powi(2) / own_size } else { 0.0 }
        };
        let gains: Vec<f64> = self.columns.iter().map(gain).collect();
        let mut order: Vec<usize> = (0..library.len()).collect();
        order.sort_by(|&a, &b| gains[b].total_cmp(&gains[a]));
        order.truncate(SCREENED_AGAIN);
        // In the order of the library, so that terms of one place stay together.
        order.sort_unstable();
        order.into_iter().map(|k| library[k].clone()).collect()
    }
}

/// The library as definitions, a few terms in each.
pub(super) fn blocks(space: &dyn TermSpace, terms: &[Term]) -> Vec<Definition> {
    let (variables, places) = (space.variables(), space.places());
    let of = |(k, block): (usize, &[Term])| {
        Definition::flexible(&format!("block{k}"), block, f64::INFINITY, variables, places)
    };
    grouped(terms).enumerate().map(of).collect()
}

/// Sensitivities to terms at a hypothesis. Each [`grouped`] block of them is a candidate, from `first` on.
pub(super) fn columns(
    (problem, hypothesis): (&Problem<'_, Dyn<'_>>, &Hypothesis),
    design: &Design,
    terms: &[Term],
    first: usize,
) -> Vec<Vec<f64>> {
    let candidates: Vec<(usize, Vec<f64>)> =
        grouped(terms).enumerate().map(|(k, block)| (first + k, vec![0.0; block.len()])).collect();
    let found = design.columns(problem, hypothesis, &candidates);
    let empty = |block: &[Term]| vec![vec![0.0; design.target.len()]; block.len()];
    found
        .into_iter()
        .zip(grouped(terms))
        .flat_map(|(own, block)| own.unwrap_or_else(|| empty(block)))
        .collect()
}

/// The best sums of terms of each length, with coefficients.
pub(super) fn sums(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    design: &Design,
    terms: &[Term],
    columns: &[Vec<f64>],
    rows_per_observation: f64,
) -> Vec<Vec<Term>> {
    let settings = &ground.settings.remainder;
    let price = |t: &Term| 2.0 * t.description_length(space.variables(), space.places());
    let prices: Vec<f64> = terms.iter().map(price).collect();
    let least = vec![1.0; design.channels()];
    let all = Scores { design, rows_per_observation, least }.beam(
        columns,
        &prices,
        settings.terms,
        settings.beam,
    );
    let mut chosen = Vec::new();
    for length in 1..=settings.terms {
        let own = all.iter().filter(|s| s.columns.len() == length).take(settings.refined);
        chosen.extend(own.map(|s| {
            let with = |(k, c): (&usize, &f64)| {
                let term = &terms[*k];
                Term { coefficient: c * term.coefficient, ..term.clone() }
            };
            s.columns.iter().zip(&s.coefficients).map(with).collect::<Vec<Term>>()
        }));
    }
    chosen
}
