//! The fit of a hypothesis by Levenberg–Marquardt.

use super::hypothesis::Hypothesis;
use super::likelihood::ChannelErrors;
use super::problem::{Problem, Sensitivities};
use crate::error::DiagnoseError;
use crate::search::{Candidates, Nuisance};
use pam_core::parallel;

/// A hypothesis at its best fit.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The hypothesis with fitted values.
    pub hypothesis: Hypothesis,
    /// Errors on the fitted rows.
    pub errors: ChannelErrors,
    /// The minimised cost, [`Problem::cost`].
    pub cost: f64,
    /// Names of parameters that ended at a limit of their range.
    pub at_limit: Vec<&'static str>,
    /// Number of logarithmic parameters (lengths, times, cutoffs) among them.
    pub scales_at_limit: usize,
    /// Drop of the cost by the last iteration; the fit has converged if it is small.
    pub last_drop: f64,
    /// Damping of the next iteration.
    damping: f64,
    /// Drop of the cost below which it has converged.
    converged_drop: f64,
}

impl Fit {
    /// Whether the last iteration changed next to nothing.
    #[must_use]
    pub fn has_converged(&self) -> bool {
        self.last_drop < self.converged_drop
    }

    /// The cost that further iterations may reach: drops fall by at least a quarter from one to the next.
    #[must_use]
    pub fn may_reach(&self) -> f64 {
        self.cost - 3.0 * self.last_drop
    }
}

impl<C: Candidates + ?Sized> Problem<'_, C> {
    /// Minus two times the log-likelihood of data and nuisances, with `n` rows of which `ρ` are one observation:
    /// `n/ρ Σ_c g(MSE_c) + Σ (deviation / prior standard deviation)²`, with the `g` of [`ChannelErrors::deviance`].
    #[must_use]
    pub fn cost(&self, hypothesis: &Hypothesis, errors: &ChannelErrors) -> f64 {
        errors.rows as f64 / self.rows_per_observation * errors.deviance()
            + self.prior_cost(hypothesis)
    }

    /// The prior cost of the nuisances over its 99.9 % quantile if the priors are right: above 1 they took what is no
    /// nuisance.
    pub(crate) fn prior_strain(&self, hypothesis: &Hypothesis) -> f64 {
        let finite = |all: &[Nuisance]| all.iter().filter(|n| n.deviation.is_finite()).count();
        let count =
            finite(self.system.shared()) + hypothesis.locals.len() * finite(self.system.local());
        if count == 0 {
            return 0.0;
        }
        self.prior_cost(hypothesis)
            / pam_numerics::statistics::chi_square_quantile(0.999, count as f64)
    }

    /// `Σ (deviation / prior standard deviation)²` of the nuisances, and of parameters with a prior.
    pub(crate) fn prior_cost(&self, hypothesis: &Hypothesis) -> f64 {
        let cost = |values: &[f64], nuisances: &[Nuisance]| -> f64 {
            values.iter().zip(nuisances).map(|(d, n)| (d / n.deviation).powi(2)).sum()
        };
        let locals: f64 = hypothesis.locals.iter().map(|l| cost(l, self.system.local())).sum();
        let parameters = hypothesis.parameter_priors(self.system);
        let parameters: f64 = parameters.iter().map(|[prior, value]| (value / prior).powi(2)).sum();
        cost(&hypothesis.shared, self.system.shared()) + locals + parameters
    }

    /// Moves a hypothesis towards its best fit in at most `iterations` steps.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails at the start.
    pub fn fit(&self, start: Hypothesis, iterations: usize) -> Result<Fit, DiagnoseError> {
        self.fit_to(start, iterations, self.settings.fit.converged_drop)
    }

    /// As [`fit`](Self::fit), until an iteration lowers the cost by less than `converged_drop`.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails at the start.
    pub fn fit_to(
        &self,
        start: Hypothesis,
        iterations: usize,
        converged_drop: f64,
    ) -> Result<Fit, DiagnoseError> {
        let errors = self.errors(&start)?;
        let fit = Fit {
            cost: self.cost(&start, &errors),
            hypothesis: start,
            errors,
            at_limit: Vec::new(),
            scales_at_limit: 0,
            last_drop: f64::INFINITY,
            damping: self.settings.fit.first_damping,
            converged_drop,
        };
        self.fit_further(fit, iterations)
    }

    /// Goes on with a fit for at most `iterations` steps.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the sensitivities cannot be simulated.
    pub fn fit_further(&self, mut fit: Fit, iterations: usize) -> Result<Fit, DiagnoseError> {
        let mut held = None;
        for _ in 0..iterations {
            if fit.has_converged() {
                break;
            }
            fit.last_drop = self.improve(&mut fit, &mut held)?;
        }
        let parameters = fit.hypothesis.parameters(self.system);
        let limited: Vec<_> = parameters
            .iter()
            .filter(|p| {
                let [low, high] = p.info.range;
                let margin = 1e-9 * (high - low);
                let value = fit.hypothesis.members[p.member].values[p.value];
                value <= low + margin || value >= high - margin
            })
            .collect();
        fit.scales_at_limit = limited.iter().filter(|p| p.info.logarithmic).count();
        fit.at_limit = limited.iter().map(|p| p.info.name).collect();
        Ok(fit)
    }

    /// One iteration: the first damping whose step lowers the cost. Returns by how much; zero where no step does, or none
    /// would by enough to first order.
    ///
    /// Where the last step did what it should, the sensitivities that were `held` with it are those of the next one as well:
    /// they decide whether the fit has converged, and serve as long as their steps lower the cost as expected.
    fn improve(
        &self,
        fit: &mut Fit,
        held: &mut Option<Vec<Sensitivities>>,
    ) -> Result<f64, DiagnoseError> {
        let settings = &self.settings.fit;
        if let Some(mut before) = held.take() {
            let here: Result<Vec<_>, DiagnoseError> =
                parallel::map(self.len(), |i| self.own_whitened_residuals(&fit.hypothesis, i))
                    .into_iter()
                    .collect();
            before.iter_mut().zip(here?).for_each(|(s, residuals)| s.residuals = residuals);
            let equations = self.normal_equations_of(&before, &fit.hypothesis, &fit.errors);
            let step = equations.step(fit.damping, self.system.shared());
            let expected = step.as_ref().map_or(0.0, |s| equations.expected_drop(s));
            if step.is_some() && expected < fit.converged_drop {
                return Ok(0.0);
            }
            if let Some((next, errors, cost)) = self.after(fit, step)
                && fit.cost - cost > settings.held_drop * expected
            {
                let drop = fit.cost - cost;
                (fit.hypothesis, fit.errors, fit.cost) = (next, errors, cost);
                *held = Some(before);
                return Ok(drop);
            }
        }
        let here: Result<Vec<Sensitivities>, DiagnoseError> =
            parallel::map(self.len(), |i| self.whitened_sensitivities(&fit.hypothesis, i))
                .into_iter()
                .collect();
        let here = here?;
        let equations = self.normal_equations_of(&here, &fit.hypothesis, &fit.errors);
        for _ in 0..settings.dampings_per_iteration {
            let step = equations.step(fit.damping, self.system.shared());
            let expected = step.as_ref().map(|s| equations.expected_drop(s));
            if expected.is_some_and(|drop| drop < fit.converged_drop) {
                return Ok(0.0);
            }
            if let Some((next, errors, cost)) = self.after(fit, step)
                && cost < fit.cost
            {
                let drop = fit.cost - cost;
                (fit.hypothesis, fit.errors, fit.cost) = (next, errors, cost);
                let less = fit.damping * settings.damping_after_success;
                fit.damping = less.max(settings.least_damping);
                let as_expected = expected.is_some_and(|e| drop > settings.held_drop * e);
                *held = as_expected.then_some(here);
                return Ok(drop);
            }
            fit.damping *= settings.damping_after_failure;
        }
        Ok(0.0)
    }

    /// The hypothesis after a step, with its errors and its cost; `None` if there is no step or it cannot be simulated.
    fn after(
        &self,
        fit: &Fit,
        step: Option<Vec<f64>>,
    ) -> Option<(Hypothesis, ChannelErrors, f64)> {
        let largest = self.settings.fit.largest_log_step;
        let next = fit.hypothesis.moved(self.system, &step?, largest);
        let errors = self.errors(&next).ok()?;
        let cost = self.cost(&next, &errors);
        Some((next, errors, cost))
    }
}
