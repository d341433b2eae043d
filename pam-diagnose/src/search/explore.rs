//! Candidates against each other.

use super::split::Split;
use crate::fit::{ChannelErrors, Fit, Hypothesis};
use pam_effects::effects::{AnyEffect, DataScales};
use rayon::prelude::*;

/// A fitted hypothesis with its judgement.
#[derive(Debug, Clone)]
pub struct Scored<'e> {
    /// The fit.
    pub fit: Fit<'e>,
    /// Errors on held-out rows.
    pub held: ChannelErrors,
    /// Minus two times the log-likelihood of all rows, with the tie and complexity costs.
    pub total: f64,
}

/// Everything that a search needs.
#[derive(Debug)]
pub struct Search<'a, 'e> {
    /// What is fitted and what judges.
    pub split: Split<'a>,
    /// Candidates.
    pub candidates: Vec<&'e dyn AnyEffect>,
    /// Magnitudes for starting values.
    pub scales: DataScales,
}

/// Which of an effect's starting values are tried.
struct Starts {
    /// All of these.
    first: Vec<Vec<f64>>,
    /// These as well if none of the first ones is better than leaving the effect out.
    otherwise: Vec<Vec<f64>>,
}

/// From an effect and all its starting values those that are tried.
type Choice<'c> = dyn Fn(&dyn AnyEffect, Vec<Vec<f64>>) -> Starts + 'c;

impl Starts {
    fn all(first: Vec<Vec<f64>>) -> Self {
        Self { first, otherwise: Vec::new() }
    }
}

/// Iterations from each starting value before the best one of a candidate is followed.
const SCREENING: usize = 2;
/// The same beside other effects, where candidates start from their fit alone.
const SCREENING_BESIDE: usize = 1;
/// What a scale at the end of its range costs: the name stands for something else there.
const LIMIT_COST: f64 = 12.0;
/// Iterations to the best fit.
const CONVERGING: usize = 10;

impl<'e> Search<'_, 'e> {
    /// Judges a fit on the held-out rows; `None` if the simulation diverges there.
    #[must_use]
    pub fn score(&self, fit: Fit<'e>) -> Option<Scored<'e>> {
        let held = self.split.held_errors(&fit.hypothesis).ok()?;
        let problem = &self.split.train;
        let rows = (fit.errors.rows + held.rows) as f64;
        let complexity = fit.hypothesis.parameter_len() as f64 * (rows / 25.0).max(2.0).ln();
        let judged = held.rows as f64 / 25.0 * held.deviance(&problem.floors);
        let limits = LIMIT_COST * fit.scales_at_limit() as f64;
        Some(Scored { total: fit.cost + judged + complexity + limits, held, fit })
    }

    /// The base model with its uncertain numbers fitted.
    #[must_use]
    pub fn base(&self, fixed: &[(&'e dyn AnyEffect, Vec<f64>)]) -> Option<Scored<'e>> {
        let start = Hypothesis::base(fixed, self.split.train.len());
        self.split.train.fit(start, CONVERGING).ok().and_then(|fit| self.score(fit))
    }

    /// Adds each candidate in turn to the base, from all its starting values, and follows the best start of
    /// each to the end. Best first.
    #[must_use]
    pub fn singles(&self, base: &Hypothesis<'e>) -> Vec<Scored<'e>> {
        let starts = |_: &dyn AnyEffect, all| Starts::all(all);
        self.extend(base, &starts, SCREENING, self.candidates.len())
    }

    /// Adds each candidate in turn to a set, from where it fits alone and from its first starting values, and
    /// follows the `keep` most promising to the end. Best first.
    #[must_use]
    pub fn beside(
        &self,
        set: &Hypothesis<'e>,
        singles: &[Scored<'e>],
        keep: usize,
    ) -> Vec<Scored<'e>> {
        let starts = |effect: &dyn AnyEffect, all: Vec<Vec<f64>>| {
            let alone = singles
                .iter()
                .filter(|s| s.fit.at_limit.is_empty())
                .filter_map(|s| s.fit.hypothesis.fitted().last())
                .find(|(e, _)| e.info().id == effect.info().id)
                .map(|(_, values)| values.to_vec());
            let scales = effect.info().parameters.iter().any(|p| p.logarithmic);
            let anew = all.into_iter();
            match alone {
                // Alone, a number may have gone far to stand for another cause.
                Some(values) if !scales => {
                    Starts { first: vec![values], otherwise: anew.take(1).collect() }
                }
                // A scale may have settled in a valley that another cause has dug.
                Some(values) => Starts::all(std::iter::once(values).chain(anew.take(2)).collect()),
                None => Starts::all(anew.take(3).collect()),
            }
        };
        self.extend(set, &starts, SCREENING_BESIDE, keep)
    }

    /// Whether every fitted effect still is what its name says.
    pub(super) fn stands(&self, hypothesis: &Hypothesis<'e>) -> bool {
        hypothesis.fitted().all(|(effect, values)| effect.stands(values, &self.scales))
    }

    fn extend(
        &self,
        from: &Hypothesis<'e>,
        choose: &Choice<'_>,
        screening: usize,
        keep: usize,
    ) -> Vec<Scored<'e>> {
        let problem = &self.split.train;
        let present = from.ids();
        let chosen: Vec<(usize, Starts)> = self
            .candidates
            .iter()
            .enumerate()
            .filter(|(_, c)| !present.contains(&c.info().id))
            .map(|(i, c)| (i, choose(*c, c.starts(&self.scales))))
            .collect();
        let mut best: Vec<Option<Fit<'e>>> = vec![None; self.candidates.len()];
        let screen = |starts: Vec<(usize, &Vec<f64>)>, best: &mut [Option<Fit<'e>>]| {
            let fits: Vec<Option<(usize, Fit<'e>)>> = starts
                .into_par_iter()
                .map(|(i, values)| {
                    let start = from.with(self.candidates[i], values);
                    problem.fit(start, screening).ok().map(|fit| (i, fit))
                })
                .collect();
            for (i, fit) in fits.into_iter().flatten() {
                if best[i].as_ref().is_none_or(|b| fit.cost < b.cost) {
                    best[i] = Some(fit);
                }
            }
        };
        screen(
            chosen.iter().flat_map(|(i, s)| s.first.iter().map(|v| (*i, v))).collect(),
            &mut best,
        );
        let without = problem.errors(from).map_or(f64::INFINITY, |e| problem.cost(from, &e));
        let helps = |fit: &Option<Fit<'e>>| fit.as_ref().is_some_and(|f| f.cost < without);
        let again = chosen
            .iter()
            .filter(|(i, _)| !helps(&best[*i]))
            .flat_map(|(i, s)| s.otherwise.iter().map(|v| (*i, v)))
            .collect();
        screen(again, &mut best);
        let mut promising: Vec<Fit<'e>> = best.into_iter().flatten().collect();
        promising.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        promising.truncate(keep);
        let mut scored: Vec<Scored<'e>> = promising
            .into_par_iter()
            .filter_map(|fit| {
                let fit = self.split.train.fit(fit.hypothesis, CONVERGING).ok()?;
                self.stands(&fit.hypothesis).then(|| self.score(fit)).flatten()
            })
            .collect();
        scored.sort_by(|a, b| a.total.total_cmp(&b.total));
        scored
    }
}
