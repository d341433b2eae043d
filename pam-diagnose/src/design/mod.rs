//! Experiment design: how well an experiment would distinguish a named cause from an alternative.
//!
//! Under each excitation the system is simulated with the named cause and, in its place, with the alternative; what the
//! alternative's own parameters could still make up for is removed with its sensitivities. The rest, in units of the
//! noise, is the separation. The excitation that separates the worst pair best is the one to run.

use crate::fit::{Hypothesis, dot, fitted_outputs};
use crate::search::Candidates;
use pam_numerics::ScaledCholesky;

/// Ridge, relative to unit columns.
const RIDGE: f64 = 1e-9;

/// Root mean square over all experiments of a system of the difference between two hypotheses, in units of the noise,
/// less what the parameters of the member at `place` of the second make up for. The system must have one grid point per
/// row. `None` if one of them cannot be simulated.
pub(crate) fn difference<C: Candidates + ?Sized>(
    system: &C,
    named: &Hypothesis,
    other: &Hypothesis,
    place: usize,
    noise: &[f64],
) -> Option<f64> {
    let count = |m: &crate::fit::Member| system.candidate(m.candidate).parameters.len();
    let first: usize = other.members[..place].iter().map(count).sum();
    let parameters = count(&other.members[place]);
    let mut rows: Vec<f64> = Vec::new();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); parameters];
    for (e, local) in named.locals.iter().enumerate() {
        let truth = system.simulate(named, local, e, system.points(e)).ok()?;
        let simulated = system.simulate(other, local, e, system.points(e)).ok()?;
        let s = system.sensitivities(other, local, e, 0..system.points(e)).ok()?;
        for (k, ((c, _), noise)) in fitted_outputs(system).zip(noise).enumerate() {
            rows.extend(truth[c].iter().zip(&simulated[c]).map(|(a, b)| (a - b) / noise));
            for (column, by) in columns.iter_mut().zip(&s.columns[first..]) {
                column.extend(by[k].iter().map(|d| d / noise));
            }
        }
    }
    let gram = |i: usize, j: usize| dot(&columns[i], &columns[j]);
    let right: Vec<f64> = columns.iter().map(|c| dot(c, &rows)).collect();
    let steps = ScaledCholesky::new(parameters, gram, RIDGE)?.solve(&right)?;
    for (step, column) in steps.iter().zip(&columns) {
        rows.iter_mut().zip(column).for_each(|(r, c)| *r -= step * c);
    }
    Some((dot(&rows, &rows) / rows.len() as f64).sqrt())
}
