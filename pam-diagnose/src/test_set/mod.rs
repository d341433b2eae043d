//! The test set: rows that no fit, search or rejection of a name has read.
//!
//! A [`TestSet`] does not give its rows away. It answers only for hypotheses that are final: their errors, the error
//! reduction, the share that a flexible model explains, and trajectories for figures.

mod error_reduction;
mod trace;

pub use error_reduction::{ChannelReduction, ErrorReduction, GroupReduction, OverallReduction};
pub use trace::Trace;

use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Problem};
use crate::onset::{LateFault, late_fault, with_own_times};
use crate::search::Candidates;
use crate::verdict::anomalies::anomalies;
use crate::verdict::bands::bands;
use crate::verdict::{Anomaly, ChannelBand};
use pam_numerics::statistics::{mean, mean_half_width_95};

/// Drop of the prior cost of nuisances that is clear by itself: χ² of one degree of freedom exceeds it once in 600 cases.
const CLEAR_PRIOR_COST: f64 = 10.0;

/// The test rows.
#[derive(Debug)]
pub struct TestSet<'a, C: ?Sized> {
    problem: Problem<'a, C>,
    /// Whether the test rows are a part of the recordings that were fitted.
    same_experiments: bool,
}

impl<'a, C: Candidates + ?Sized> TestSet<'a, C> {
    pub(crate) fn new(problem: Problem<'a, C>, same_experiments: bool) -> Self {
        Self { problem, same_experiments }
    }

    /// The test rows with what nuisances of their own recordings would take out of a hypothesis.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails.
    pub(crate) fn opened(mut self, base: &Hypothesis) -> Result<Self, DiagnoseError> {
        if !self.same_experiments {
            let base = Hypothesis { locals: self.problem.base().locals, ..base.clone() };
            self.problem = self.problem.as_unseen(&base)?;
        }
        Ok(self)
    }

    /// Normalised χ² of a hypothesis; infinite if the simulation fails.
    pub(crate) fn chi_square(&self, hypothesis: &Hypothesis) -> f64 {
        let errors = self.problem.errors(&self.here(hypothesis));
        errors.map_or(f64::INFINITY, |e| e.chi_square())
    }

    /// Whether the whitened squared error is proven to be smaller by `after` than by `before`: Student's one-sided test at
    /// 97.5 % of the differences over blocks of time, or of the differences relative to the sums, which a few blocks with
    /// all of the error (a delay where levels step) do not scatter.
    ///
    /// The nuisances of both are fitted to the test rows alone. A hypothesis that predicts as well, but with starts, masses or
    /// numbers of the model that are far from their measured values, is not as likely.
    pub(crate) fn is_reduced(&self, before: &Hypothesis, after: &Hypothesis) -> bool {
        let problem = self.problem.as_fitted();
        let iterations = problem.settings.search.tried_iterations;
        let fitted = |h: &Hypothesis| {
            let here = self.here(h);
            let held = Hypothesis { fixed: here.members.len(), ..here };
            problem.fit(held, iterations).map(|fit| fit.hypothesis)
        };
        let (Ok(before), Ok(after)) = (fitted(before), fitted(after)) else { return false };
        // Nuisances that are as measured speak for a cause.
        let taken = problem.prior_cost(&before) - problem.prior_cost(&after);
        let (mut gains, mut relative) = (Vec::new(), Vec::new());
        for i in 0..problem.len() {
            let squares = |h| problem.squares_by_block(h, i);
            let (Ok(old), Ok(new)) = (squares(&before), squares(&after)) else { return false };
            let block = problem.rows_per_short_block(i) as f64;
            for (old, new) in old.into_iter().zip(new) {
                gains.push((old - new) / block);
                relative.push((old - new) / (old + new).max(f64::MIN_POSITIVE));
            }
        }
        let (gain, of_relative) = (mean(&gains), mean(&relative));
        let half = mean_half_width_95(&gains);
        let clear = half.is_some_and(|h| gain > h || (taken > CLEAR_PRIOR_COST && gain > -h));
        clear || (gain > 0.0 && mean_half_width_95(&relative).is_some_and(|h| of_relative > h))
    }

    /// Each channel beside its noise under a hypothesis that was fitted to `open` rows; empty if the simulation fails.
    pub(crate) fn bands(&self, open: &Problem<'_, C>, hypothesis: &Hypothesis) -> Vec<ChannelBand> {
        let here = self.here(hypothesis);
        bands((open, hypothesis), (&self.problem, &here)).unwrap_or_default()
    }

    /// Anomalies in the residual of a hypothesis, in the test rows and in the `open` ones.
    pub(crate) fn anomalies(&self, open: &Problem<'_, C>, hypothesis: &Hypothesis) -> Vec<Anomaly> {
        if self.same_experiments {
            // An error may begin with the test rows.
            let whole = open.with_windows(|place, e| {
                let test = self.problem.experiments.iter().position(|&t| t == e);
                let end = test.map_or(open.windows[place].end, |t| self.problem.windows[t].end);
                open.windows[place].start..end
            });
            return anomalies(&whole, hypothesis);
        }
        let mut all = anomalies(open, hypothesis);
        all.extend(anomalies(&self.problem, &self.here(hypothesis)));
        all
    }

    /// A hypothesis with the times at which something begins or ends in the test recordings, where each recording has its own.
    pub(crate) fn with_own_times(&self, hypothesis: &Hypothesis) -> Hypothesis {
        let found = with_own_times(&self.problem, &self.here(hypothesis));
        Hypothesis { members: found.members, ..hypothesis.clone() }
    }

    /// What is there in the test rows only, beside a hypothesis that was fitted to `open` rows.
    pub(crate) fn late_fault(
        &self,
        open: &Problem<'_, C>,
        hypothesis: &Hypothesis,
        screened: &[(usize, Vec<f64>)],
        seed: u64,
    ) -> Option<LateFault> {
        late_fault(open, &self.problem, hypothesis, screened, seed)
    }

    /// The strongest factor on which what is left of a channel depends, with the share of its variance.
    pub(crate) fn goes_with(
        &self,
        hypothesis: &Hypothesis,
        channel: usize,
    ) -> Option<(String, f64)> {
        let (problem, here) = (&self.problem, self.here(hypothesis));
        let residuals: Vec<Vec<Vec<f64>>> = (0..problem.len())
            .map(|i| problem.residuals(&here, i))
            .collect::<Result<_, _>>()
            .ok()?;
        let factors = crate::residual::Factors::of(problem, &here, &residuals);
        let values: Vec<f64> = residuals.iter().flat_map(|r| &r[channel]).copied().collect();
        let rows = crate::noise::correlated_rows(&values, &problem.settings.noise);
        let all = factors.dependences(&values, rows, problem.settings.residual.groups);
        all.into_iter().next().map(|d| (d.factor, d.share))
    }

    /// The fitted channels.
    pub(crate) fn problem(&self) -> &Problem<'a, C> {
        &self.problem
    }

    fn here(&self, hypothesis: &Hypothesis) -> Hypothesis {
        if self.same_experiments {
            return hypothesis.clone();
        }
        Hypothesis { locals: self.problem.base().locals, ..hypothesis.clone() }
    }
}
