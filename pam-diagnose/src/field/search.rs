//! Sets of candidates: forward in a beam, then backward.

use super::candidate::{Candidate, FieldOptions};
use super::residual::describe;
use super::result::{FieldCause, FieldDiagnosis, RankedSet};
use crate::diagnosis::weigh;
use crate::error::DiagnoseError;
use crate::fit::{Interval, deviance};
use pam_autodiff::{ByDual, Differentiation};
use pam_core::ParametricField;
use pam_solvers::ParametricInput;
use pam_train::field::{FieldError, FieldFit, FieldProblem, LeastSquares};

/// Sets that are extended at each size.
const BEAM: usize = 3;
/// Squared error over that of the noise, summed as over three outputs, below which nothing more is asked.
const SATISFIED: f64 = 4.0;
/// Difference of the total below which another set counts as an alternative.
const AS_WELL: f64 = 12.0;

/// A fitted set.
#[derive(Clone)]
struct Scored {
    set: Vec<usize>,
    fit: FieldFit,
    held: Vec<f64>,
    all: Vec<f64>,
    total: f64,
}

struct Search<'a, 'p, F, I> {
    problem: &'a FieldProblem<'p, F, I>,
    candidates: &'a [Candidate],
    options: &'a FieldOptions,
    /// All candidates off.
    plain: Vec<f64>,
    ranges: Vec<[f64; 2]>,
    rows_per_observation: f64,
}

/// Names what a field misses, out of the candidates that its author lists.
///
/// Every experiment is fitted up to its last third, which judges (see [`FieldOptions`]). The residual is
/// described first; then sets of candidates grow in a beam and shrink again, as in
/// [`diagnose`](crate::diagnose): a cause must lower the deviance of held-out rows and the total cost, and the
/// interval of what switches it on must not hold the value at which it is off.
///
/// # Errors
/// [`DiagnoseError`] if the shapes do not fit or the field without any cause cannot be solved.
pub fn diagnose_field<F, I>(
    problem: &FieldProblem<'_, F, I>,
    candidates: &[Candidate],
    options: &FieldOptions,
) -> Result<FieldDiagnosis, DiagnoseError>
where
    F: ParametricField + Sync,
    F::With<f64>: ParametricField,
    ByDual: Differentiation<F::With<f64>>,
    I: ParametricInput + Sync,
{
    problem.check()?;
    check(problem.field.parameter_len(), candidates, options)?;
    let mut plain = problem.field.parameters();
    let mut ranges = vec![[f64::NEG_INFINITY, f64::INFINITY]; plain.len()];
    for candidate in candidates {
        candidate.switch_off(&mut plain);
        for (index, info) in &candidate.parameters {
            ranges[*index] = info.range;
        }
    }
    let (residual, rows_per_observation) = describe(problem, &plain)?;
    let search = Search { problem, candidates, options, plain, ranges, rows_per_observation };
    let base = search.base()?;
    let (singles, best, others) = search.run(&base);
    search.diagnosis(residual, &base, singles, &best, others)
}

fn check(
    len: usize,
    candidates: &[Candidate],
    options: &FieldOptions,
) -> Result<(), DiagnoseError> {
    let fail = |what: String| Err(FieldError::Shape(what).into());
    for c in candidates {
        let fits = |s: &Vec<f64>| s.len() == c.parameters.len();
        if c.parameters.iter().any(|(i, _)| *i >= len)
            || !c.starts.iter().all(fits)
            || c.starts.is_empty()
        {
            return fail(format!(
                "candidate `{}`: parameters {:?} and starting values {:?} do not fit a field of {len} \
                 parameters",
                c.name,
                c.parameters.iter().map(|p| p.0).collect::<Vec<_>>(),
                c.starts
            ));
        }
    }
    if let Some(bad) = options.refitted.iter().find(|&&i| i >= len) {
        return fail(format!("the field has no parameter {bad} to refit"));
    }
    if !(0.05..=0.9).contains(&options.held_share) {
        return fail(format!(
            "the held-out share must be from 0.05 to 0.9, got {}",
            options.held_share
        ));
    }
    Ok(())
}

impl<F, I> Search<'_, '_, F, I>
where
    F: ParametricField + Sync,
    F::With<f64>: ParametricField,
    ByDual: Differentiation<F::With<f64>>,
    I: ParametricInput + Sync,
{
    fn base(&self) -> Result<Scored, DiagnoseError> {
        Ok(self.fit(&[], self.plain.clone())?)
    }

    /// Fits a set from the given values and judges it.
    fn fit(&self, set: &[usize], start: Vec<f64>) -> Result<Scored, FieldError> {
        let mut free = self.options.refitted.clone();
        free.extend(set.iter().flat_map(|&c| self.candidates[c].parameters.iter().map(|p| p.0)));
        free.sort_unstable();
        free.dedup();
        let until = 1.0 - self.options.held_share;
        let fit = self.problem.least_squares(&LeastSquares {
            free: Some(free),
            start: Some(start),
            ranges: Some(self.ranges.clone()),
            iterations: Some(self.options.iterations),
            until: Some(until),
        })?;
        let (held, all) = self.judge(&fit, until)?;
        let noise = &self.problem.outputs.noise;
        let rows: usize = self.problem.experiments.iter().map(|e| e.times_s.len()).sum();
        let observations = rows as f64 / self.rows_per_observation;
        let complexity = fit.free.len() as f64 * observations.max(2.0).ln();
        let total = observations * deviance(&all, noise) + complexity;
        Ok(Scored { set: set.to_vec(), fit, held, all, total })
    }

    /// Mean squared errors of the held-out rows and of all rows.
    fn judge(&self, fit: &FieldFit, until: f64) -> Result<(Vec<f64>, Vec<f64>), FieldError> {
        let outputs = self.problem.outputs.len();
        let mut held = (vec![0.0; outputs], 0.0_f64);
        let mut all = held.clone();
        for (k, states) in self.problem.predict(&fit.parameters)?.iter().enumerate() {
            let errors = self.problem.errors(k, states);
            let first = ((errors.len() / outputs) as f64 * until).ceil() as usize;
            for (row, error) in errors.chunks_exact(outputs).enumerate() {
                let judged = row >= first;
                for sums in std::iter::once(&mut all).chain(judged.then_some(&mut held)) {
                    sums.1 += 1.0;
                    sums.0.iter_mut().zip(error).for_each(|(s, e)| *s += e * e);
                }
            }
        }
        let mean = |(sums, rows): (Vec<f64>, f64)| sums.iter().map(|s| s / rows.max(1.0)).collect();
        Ok((mean(held), mean(all)))
    }

    /// Squared error of all rows over that of the noise, as a sum over three outputs: 3 at the noise.
    fn level(&self, scored: &Scored) -> f64 {
        let noise = &self.problem.outputs.noise;
        let ratios: f64 = scored.all.iter().zip(noise).map(|(m, n)| m / (n * n)).sum();
        3.0 * ratios / noise.len() as f64
    }

    fn earns(&self, from: &Scored, to: &Scored, members: usize) -> bool {
        let noise = &self.problem.outputs.noise;
        let asked = &self.options.acceptance;
        let held = deviance(&from.held, noise) - deviance(&to.held, noise);
        let total = from.total - to.total;
        held >= asked.held_drop * members as f64 && total >= asked.total_drop * members as f64
    }

    /// Adds a candidate to a set, from each of its starting values; the best fit.
    fn beside(&self, set: &Scored, candidate: usize) -> Option<Scored> {
        let mut members = set.set.clone();
        members.push(candidate);
        members.sort_unstable();
        let info = &self.candidates[candidate];
        info.starts
            .iter()
            .filter_map(|values| {
                let mut start = set.fit.parameters.clone();
                for ((index, _), value) in info.parameters.iter().zip(values) {
                    start[*index] = *value;
                }
                self.fit(&members, start).ok()
            })
            .min_by(|a, b| a.total.total_cmp(&b.total))
    }

    /// Every candidate alone, the chosen set, and the other sets that were tried.
    fn run(&self, base: &Scored) -> (Vec<Scored>, Scored, Vec<Scored>) {
        let mut singles: Vec<Scored> =
            (0..self.candidates.len()).filter_map(|c| self.beside(base, c)).collect();
        singles.sort_by(|a, b| a.total.total_cmp(&b.total));
        let mut best = base.clone();
        let mut others = singles.clone();
        let mut beam: Vec<Scored> = singles.iter().take(BEAM).cloned().collect();
        for size in 1..=self.options.most_causes {
            let Some(top) = beam.first() else { break };
            if self.earns(&best, top, size - best.set.len()) {
                best = top.clone();
            } else if size > 1 {
                // A pair may show what neither shows alone; beyond that, only a set that grew grows on.
                break;
            }
            if self.level(&best) < SATISFIED || size == self.options.most_causes {
                break;
            }
            let mut next: Vec<Scored> = Vec::new();
            for set in &beam {
                for c in (0..self.candidates.len()).filter(|c| !set.set.contains(c)) {
                    let mut members = set.set.clone();
                    members.push(c);
                    members.sort_unstable();
                    if !next.iter().any(|s| s.set == members) {
                        next.extend(self.beside(set, c));
                    }
                }
            }
            next.sort_by(|a, b| a.total.total_cmp(&b.total));
            others.extend(next.iter().cloned());
            next.truncate(BEAM);
            beam = next;
        }
        (singles, self.backward(best), others)
    }

    /// Drops members that are not worth their place once the others are there, or that may be off.
    fn backward(&self, mut best: Scored) -> Scored {
        loop {
            let less = best
                .set
                .iter()
                .filter_map(|&c| Some((c, self.without(&best, c)?)))
                .filter(|(c, less)| !self.earns(less, &best, 1) || self.may_be_off(&best, *c))
                .map(|(_, less)| less)
                .min_by(|a, b| a.total.total_cmp(&b.total));
            match less {
                Some(less) => best = less,
                None => return best,
            }
        }
    }

    fn without(&self, scored: &Scored, candidate: usize) -> Option<Scored> {
        let set: Vec<usize> = scored.set.iter().copied().filter(|&c| c != candidate).collect();
        let mut start = scored.fit.parameters.clone();
        self.candidates[candidate].switch_off(&mut start);
        self.fit(&set, start).ok()
    }

    /// Whether the intervals of all that switches a cause on hold the values at which it is off.
    fn may_be_off(&self, scored: &Scored, candidate: usize) -> bool {
        let mut switches = self.candidates[candidate]
            .parameters
            .iter()
            .filter_map(|(index, info)| Some((scored.fit.interval(*index)?, info.off?)))
            .peekable();
        switches.peek().is_some() && switches.all(|([low, high], off)| !(off < low || off > high))
    }

    fn ranked(&self, scored: &Scored) -> RankedSet {
        RankedSet {
            names: scored.set.iter().map(|&c| self.candidates[c].name.clone()).collect(),
            total: scored.total,
            held_rmse: rmse(&scored.held),
        }
    }

    fn diagnosis(
        &self,
        residual: Vec<super::OutputStory>,
        base: &Scored,
        singles: Vec<Scored>,
        best: &Scored,
        mut others: Vec<Scored>,
    ) -> Result<FieldDiagnosis, DiagnoseError> {
        let verdict = weigh(self.level(base), self.level(best), 3.0, best.set.len());
        let noise = &self.problem.outputs.noise;
        let mut causes: Vec<FieldCause> = best
            .set
            .iter()
            .map(|&c| {
                let without = self.without(best, c);
                let own = deviance(&best.held, noise);
                FieldCause {
                    name: self.candidates[c].name.clone(),
                    parameters: self.candidates[c]
                        .parameters
                        .iter()
                        .map(|(index, info)| {
                            let value = best.fit.parameters[*index];
                            let ci95 = best.fit.interval(*index).unwrap_or([value; 2]);
                            (info.name, Interval { value, ci95 })
                        })
                        .collect(),
                    held_drop: without.map_or(f64::INFINITY, |w| deviance(&w.held, noise) - own),
                }
            })
            .collect();
        causes.sort_by(|a, b| b.held_drop.total_cmp(&a.held_drop));
        others.retain(|o| {
            o.set != best.set && o.set.len() <= best.set.len() && o.total < best.total + AS_WELL
        });
        others.sort_by(|a, b| a.total.total_cmp(&b.total));
        Ok(FieldDiagnosis {
            verdict,
            causes,
            residual,
            parameters: best.fit.parameters.clone(),
            held_rmse: [rmse(&base.held), rmse(&best.held)],
            singles: singles.iter().map(|s| self.ranked(s)).collect(),
            alternatives: others.iter().map(|s| self.ranked(s)).collect(),
        })
    }
}

fn rmse(mean_squares: &[f64]) -> Vec<f64> {
    mean_squares.iter().map(|m| m.sqrt()).collect()
}
