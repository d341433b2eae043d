//! The test set: rows that no fit, search or rejection of a name has read.
//!
//! A [`TestSet`] does not give its rows away. It answers only for hypotheses that are final: their errors, the error
//! reduction, the share that a flexible model explains, and trajectories for figures.

mod error_reduction;
mod trace;

pub use error_reduction::{ChannelReduction, ErrorReduction, GroupReduction, OverallReduction};
pub use trace::Trace;

use crate::error::DiagnoseError;
use crate::fit::{Fit, Hypothesis, Problem};
use crate::onset::{LateFault, late_fault, with_own_times};
use crate::search::{Candidates, TIE};
use crate::settings::VerdictSettings;
use crate::verdict::anomalies::anomalies;
use crate::verdict::bands::bands;
use crate::verdict::{Anomaly, ChannelBand};
use pam_core::parallel;
use pam_numerics::statistics::{
    chi_square_quantile, mean, mean_half_width_95, positive_mean_p_value,
};

/// Drop of the prior cost of nuisances that is clear by itself: χ² of one degree of freedom exceeds it once in 600 cases.
pub(crate) const CLEAR_PRIOR_COST: f64 = 10.0;

/// [Change](Comparison::change) of the simulation below which a significant test is a chance result: the expected statistic of the score test
/// is smaller than its own standard deviation.
const LEAST_CHANGE: f64 = 1.0;

/// Two hypotheses on the test rows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Comparison {
    /// Normalised χ² of both, with the prior cost of their nuisances.
    pub(crate) chi_squares: [f64; 2],
    /// Whether the whitened squared error of the second is proven to be smaller: Student's one-sided test at 97.5 % of the
    /// differences over blocks of time, or of the differences relative to the sums, which a few blocks with all of the error
    /// (a delay where levels step) do not scatter; or it is no larger, and the nuisances of the first must be far from their
    /// measured values for that; or it is smaller, and the residual `r` of the first goes with the change `s` of the simulation:
    /// Student's one-sided test of `Σ r·s` over blocks, whose mean is zero without the cause. The squared error falls by
    /// `2 r·s − s²`, which of a weak cause has half the ratio of mean to scatter.
    pub(crate) reduced: bool,
    /// Drop of the prior cost of the nuisances from the first to the second: positive where those of the second are nearer to
    /// their measured values.
    pub(crate) prior_drop: f64,
    /// Drop of minus two times the logarithm of the posterior probability. Rows over which what the second leaves is correlated count as
    /// one observation. It does not need the error to be in many blocks, as the tests of `reduced` do.
    pub(crate) evidence: f64,
    /// Norm of the change `s` over the whitened rows, with correlated rows counted as one observation: the expected statistic of the score
    /// test of `Σ r·s`, in standard deviations, if the second hypothesis is true.
    pub(crate) change: f64,
}

impl Comparison {
    /// Whether nuisances of the first are so far from their measured values that this speaks for the second by itself.
    pub(crate) fn is_strained(&self) -> bool {
        self.prior_drop > CLEAR_PRIOR_COST
    }

    /// Whether the test data confirm the second hypothesis. Errors of the measured starts and masses can exceed the effect of a weak cause
    /// and have either sign, so a significantly negative error reduction counts against it only if the fitted starts and masses are
    /// also less likely than under the first.
    /// A second hypothesis that hardly changes the simulation is not confirmed. If training and validation data have `established` the causes,
    /// decisive evidence confirms them even if it comes from few blocks, provided that the fitted starts and masses are about as likely. If
    /// the residual of the second hypothesis is `only_noise`, smaller odds are decisive than with model errors, whose likelihood is approximate.
    pub(crate) fn confirms(
        &self,
        reduction: &OverallReduction,
        established: bool,
        only_noise: bool,
        settings: &VerdictSettings,
    ) -> bool {
        let is_seen = self.change > LEAST_CHANGE || self.is_strained();
        let decisive = if only_noise {
            2.0 * settings.confusable_odds.ln()
        } else {
            settings.decisive_evidence
        };
        let is_decisive = established && self.evidence > decisive;
        let is_likely = self.prior_drop > -2.0 * TIE;
        let is_reduced = self.reduced && (is_likely || reduction.ci95[1] > 0.0);
        is_seen && (is_reduced || is_decisive && is_likely)
    }

    /// Returns true if a score test that is not significant is no evidence against the second hypothesis, under which its statistic is
    /// normal with mean `change`: its power is below one half, or it is below [`VerdictSettings::power`] and the test data are more probable
    /// under the second hypothesis.
    pub(crate) fn lacks_power(&self, settings: &VerdictSettings) -> bool {
        let normal_quantile = |p: f64| chi_square_quantile(2.0 * p - 1.0, 1.0).sqrt();
        let critical = normal_quantile(1.0 - settings.score_p_value);
        let is_likely = self.evidence > 0.0 && self.prior_drop > -2.0 * TIE;
        let margin = if is_likely { normal_quantile(settings.power) } else { 0.0 };
        self.change < critical + margin && !self.is_strained()
    }

    /// Whether the test data confirm a correction or a law: its error reduction is significant. What acts now and then, or less than the
    /// errors of the measured starts and masses do, need not be significant if it is more probable by `clear_evidence`.
    pub(crate) fn confirms_learned(
        &self,
        reduction: &OverallReduction,
        clear_evidence: f64,
    ) -> bool {
        let is_positive = reduction.ci95[0] > 0.0;
        if self.evidence > clear_evidence {
            is_positive || self.prior_drop > -2.0 * TIE
        } else {
            is_positive && self.reduced
        }
    }
}

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

    /// Checks that every recording has a row.
    ///
    /// # Errors
    /// [`DiagnoseError::TooLittle`] naming the first one without.
    pub(crate) fn check_rows(&self) -> Result<(), DiagnoseError> {
        self.problem.check_rows("test")
    }

    /// The test rows with what nuisances of their own recordings would take out of a hypothesis.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails.
    pub(crate) fn opened(mut self, base: &Hypothesis) -> Result<Self, DiagnoseError> {
        if !self.same_experiments {
            self.problem = self.problem.as_unseen(&self.problem.with_base_locals(base))?;
        }
        Ok(self)
    }

    /// Normalised χ² of a hypothesis; infinite if the simulation fails.
    pub(crate) fn chi_square(&self, hypothesis: &Hypothesis) -> f64 {
        let errors = self.problem.errors(&self.here(hypothesis));
        errors.map_or(f64::INFINITY, |e| e.chi_square())
    }

    /// Two hypotheses side by side, with the nuisances of both fitted to the test rows alone; `None` if one of them cannot be
    /// simulated.
    ///
    /// A hypothesis that predicts as well as another, but with starts, masses or numbers of the model that are further from their
    /// measured values, is not as likely: what these cost is a part of its error.
    pub(crate) fn compared(&self, before: &Hypothesis, after: &Hypothesis) -> Option<Comparison> {
        let problem = self.problem.as_fitted();
        // Next to quadratic in the nuisances.
        let search = &problem.settings.search;
        let fitted = |h: &Hypothesis| {
            let here = self.here(h);
            let held = Hypothesis { fixed: here.members.len(), ..here };
            problem.fit_to(held, search.first_iterations, search.converged_drop).ok()
        };
        let (before, after) = parallel::join(|| fitted(before), || fitted(after));
        let (before, after) = (before?, after?);
        let prior = |fit: &Fit| problem.prior_cost(&fit.hypothesis);
        // Nuisances that are as measured speak for a cause.
        let taken = prior(&before) - prior(&after);
        let (mut gains, mut relative, mut scores) = (Vec::new(), Vec::new(), Vec::new());
        let mut changed = 0.0;
        for i in 0..problem.len() {
            let residuals = |fit: &Fit| problem.whitened_residuals(&fit.hypothesis, i).ok();
            let (old, new) = (residuals(&before)?, residuals(&after)?);
            let block = problem.rows_per_short_block(i) as f64;
            let of_old = problem.products_by_block(&old, &old, i);
            let of_new = problem.products_by_block(&new, &new, i);
            let of_both = problem.products_by_block(&old, &new, i);
            for ((old, new), both) in of_old.into_iter().zip(of_new).zip(of_both) {
                gains.push((old - new) / block);
                relative.push((old - new) / (old + new).max(f64::MIN_POSITIVE));
                scores.push((old - both) / block);
                changed += old + new - 2.0 * both;
            }
        }
        let (gain, of_relative) = (mean(&gains), mean(&relative));
        let half = mean_half_width_95(&gains);
        let clear = half.is_some_and(|h| gain > h || (taken > CLEAR_PRIOR_COST && gain > -h));
        let by_blocks =
            gain > 0.0 && mean_half_width_95(&relative).is_some_and(|h| of_relative > h);
        let agrees =
            gain > 0.0 && positive_mean_p_value(&scores) < problem.settings.verdict.score_p_value;
        let chi_square = |fit: &Fit| {
            let rows = (fit.errors.rows * fit.errors.sums.len()).max(1) as f64;
            fit.errors.chi_square() + prior(fit) / rows
        };
        let correlated = problem.correlated_rows(&after.hypothesis).ok()?;
        let cost =
            |fit: &Fit| fit.errors.rows as f64 / correlated * fit.errors.deviance() + prior(fit);
        Some(Comparison {
            evidence: cost(&before) - cost(&after),
            chi_squares: [chi_square(&before), chi_square(&after)],
            reduced: clear || by_blocks || agrees,
            prior_drop: taken,
            change: (changed.max(0.0) / correlated).sqrt(),
        })
    }

    /// Whether `after` predicts the test rows significantly better than `before`, judged by the whitened squared error or by the
    /// score test: the inner product of the residual of `before` with the change of the prediction.
    #[must_use]
    pub fn is_reduced(&self, before: &Hypothesis, after: &Hypothesis) -> bool {
        self.compared(before, after).is_some_and(|c| c.reduced)
    }

    /// Each channel beside its noise under a hypothesis that was fitted to `open` rows; empty if the simulation fails.
    pub(crate) fn bands(&self, open: &Problem<'_, C>, hypothesis: &Hypothesis) -> Vec<ChannelBand> {
        self.bands_at(open, hypothesis, &self.refitted(open, hypothesis))
    }

    /// The [bands](Self::bands), and the anomalies in the residual of a hypothesis, in the test rows and in the `open` ones.
    pub(crate) fn bands_and_anomalies(
        &self,
        open: &Problem<'_, C>,
        hypothesis: &Hypothesis,
    ) -> (Vec<ChannelBand>, Vec<Anomaly>) {
        let here = self.refitted(open, hypothesis);
        let bands = self.bands_at(open, hypothesis, &here);
        if self.same_experiments {
            // An error may begin with the test rows.
            return (bands, anomalies(&self.whole(open), &here));
        }
        let mut all = anomalies(open, hypothesis);
        all.extend(anomalies(&self.problem, &here));
        (bands, all)
    }

    /// The bands with the hypothesis as it is `here`, in the test rows.
    fn bands_at(
        &self,
        open: &Problem<'_, C>,
        hypothesis: &Hypothesis,
        here: &Hypothesis,
    ) -> Vec<ChannelBand> {
        bands((open, hypothesis), (&self.problem, here)).unwrap_or_default()
    }

    /// The hypothesis in the test rows. Where they belong to the recordings that were fitted, its values are fitted to all rows of these
    /// recordings.
    ///
    /// A prediction differs from the test rows by their noise and by the uncertainty of the fitted values: its covariance is `S + Z H⁻¹ Zᵀ`
    /// with the sensitivities `Z` of the test rows and the Hessian `H` of the open ones. The residual to be compared with `S` is that of
    /// the fit to both, `min_δ |r − Z δ|² + δᵀ H δ`. Values that few rows determine are uncertain; the others hardly move.
    fn refitted(&self, open: &Problem<'_, C>, hypothesis: &Hypothesis) -> Hypothesis {
        if !self.same_experiments {
            return self.here(hypothesis);
        }
        let search = &open.settings.search;
        let whole = self.whole(open);
        let fit = whole.fit_to(hypothesis.clone(), search.first_iterations, search.converged_drop);
        fit.map_or_else(|_| hypothesis.clone(), |fit| fit.hypothesis)
    }

    /// The open rows with the test rows of the same recordings.
    fn whole<'p>(&self, open: &Problem<'p, C>) -> Problem<'p, C> {
        open.with_windows(|place, e| {
            let test = self.problem.experiments.iter().position(|&t| t == e);
            let end = test.map_or(open.windows[place].end, |t| self.problem.windows[t].end);
            open.windows[place].start..end
        })
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
        self.problem.with_base_locals(hypothesis)
    }
}
