//! Candidates added to a set, one at a time.

use super::candidates::Candidates;
use super::scored::{Scored, score};
use crate::data::Split;
use crate::fit::{Fit, Hypothesis};
use pam_core::parallel;

/// The starting values of a candidate that are tried.
struct Starts {
    /// All of these.
    first: Vec<Vec<f64>>,
    /// These as well if none of the first ones is better than leaving the candidate out.
    otherwise: Vec<Vec<f64>>,
}

impl Starts {
    fn all(first: Vec<Vec<f64>>) -> Self {
        Self { first, otherwise: Vec::new() }
    }
}

/// Adds each candidate in turn to the base, from all its starting values, and follows the best start of each to
/// convergence. Best first.
pub(super) fn alone<C: Candidates + ?Sized>(
    split: &Split<'_, C>,
    base: &Hypothesis,
) -> Vec<Scored> {
    let system = split.train.system;
    let screening = split.train.settings.search.screening_iterations;
    extend(split, base, &|c| Starts::all(system.starts(c)), screening, system.candidate_len())
}

/// Adds each candidate in turn to a set, from its values alone and from its first starting values, and follows the
/// `keep` most promising to convergence. Best first.
pub(crate) fn beside<C: Candidates + ?Sized>(
    split: &Split<'_, C>,
    set: &Hypothesis,
    singles: &[Scored],
    keep: usize,
) -> Vec<Scored> {
    let system = split.train.system;
    let settings = &split.train.settings.search;
    let most = settings.starts_added;
    let starts = |c: usize| {
        let alone = singles
            .iter()
            .filter(|s| s.fit.at_limit.is_empty())
            .filter_map(|s| s.hypothesis().members.last())
            .find(|m| m.candidate == c)
            .map(|m| m.values.clone());
        let scales = system.candidate(c).parameters.iter().any(|p| p.logarithmic);
        let anew = system.starts(c).into_iter();
        match alone {
            // Alone, a parameter may have gone far to stand for another cause.
            Some(values) if !scales => {
                Starts { first: vec![values], otherwise: anew.take(1).collect() }
            }
            // A scale may have settled in a valley that another cause has dug.
            Some(values) => {
                Starts::all(std::iter::once(values).chain(anew.take(most - 1)).collect())
            }
            None => Starts::all(anew.take(most).collect()),
        }
    };
    extend(split, set, &starts, settings.screening_iterations_added, keep)
}

fn extend<C: Candidates + ?Sized>(
    split: &Split<'_, C>,
    from: &Hypothesis,
    choose: &dyn Fn(usize) -> Starts,
    screening: usize,
    keep: usize,
) -> Vec<Scored> {
    let problem = &split.train;
    let candidates = 0..problem.system.candidate_len();
    let chosen: Vec<(usize, Starts)> =
        candidates.filter(|&c| !from.contains(c)).map(|c| (c, choose(c))).collect();
    let mut best: Vec<Option<Fit>> = vec![None; problem.system.candidate_len()];
    let screen = |starts: Vec<(usize, &Vec<f64>)>, best: &mut [Option<Fit>]| {
        let fits: Vec<Option<(usize, Fit)>> = parallel::map_each(starts, |(c, values)| {
            problem.fit(from.with(c, values), screening).ok().map(|fit| (c, fit))
        });
        for (c, fit) in fits.into_iter().flatten() {
            if best[c].as_ref().is_none_or(|b| fit.cost < b.cost) {
                best[c] = Some(fit);
            }
        }
    };
    screen(chosen.iter().flat_map(|(c, s)| s.first.iter().map(|v| (*c, v))).collect(), &mut best);
    let without = problem.errors(from).map_or(f64::INFINITY, |e| problem.cost(from, &e));
    let helps = |fit: &Option<Fit>| fit.as_ref().is_some_and(|f| f.cost < without);
    let again = chosen
        .iter()
        .filter(|(c, _)| !helps(&best[*c]))
        .flat_map(|(c, s)| s.otherwise.iter().map(|v| (*c, v)))
        .collect();
    screen(again, &mut best);
    let mut promising: Vec<Fit> = best.into_iter().flatten().collect();
    promising.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    promising.truncate(keep);
    let mut scored: Vec<Scored> = parallel::map_each(promising, |fit| {
        let fit = problem.fit(fit.hypothesis, problem.settings.search.iterations).ok()?;
        stands(problem.system, &fit.hypothesis).then(|| score(split, fit)).flatten()
    })
    .into_iter()
    .flatten()
    .collect();
    scored.sort_by(|a, b| a.total.total_cmp(&b.total));
    scored
}

/// Whether every member still is what its name says.
pub(super) fn stands<C: Candidates + ?Sized>(system: &C, hypothesis: &Hypothesis) -> bool {
    hypothesis.members.iter().all(|m| system.stands(m.candidate, &m.values))
}
