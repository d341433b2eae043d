//! The fit of a hypothesis by Levenberg–Marquardt.

use super::hypothesis::Hypothesis;
use super::likelihood::ChannelErrors;
use super::normal::{Jacobian, WhitenedResiduals};
use super::problem::Problem;
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

/// `Σ (value / prior standard deviation)²` over nuisances for which a condition holds.
fn squares(values: &[f64], nuisances: &[Nuisance], of: impl Fn(&Nuisance) -> bool) -> f64 {
    let all = values.iter().zip(nuisances).filter(|(_, n)| of(n));
    all.map(|(value, n)| (value / n.deviation).powi(2)).sum()
}

impl<C: Candidates + ?Sized> Problem<'_, C> {
    /// Minus two times the log-likelihood of data and nuisances, with `n` rows of which `ρ` are one observation:
    /// `n/ρ Σ_c g(MSE_c) + Σ (deviation / prior standard deviation)²`, with the `g` of [`ChannelErrors::deviance`].
    #[must_use]
    pub fn cost(&self, hypothesis: &Hypothesis, errors: &ChannelErrors) -> f64 {
        errors.rows as f64 / self.rows_per_observation * errors.deviance()
            + self.prior_cost(hypothesis)
    }

    /// The prior cost of the nuisances that have no limits over its 99.9 % quantile if the priors are right: above 1
    /// they have absorbed an error that is not theirs. A nuisance with limits may be anywhere between them.
    pub(crate) fn prior_strain(&self, hypothesis: &Hypothesis) -> f64 {
        let most = self.most_prior_cost(hypothesis);
        let (shared, local) = (self.system.shared(), self.system.local());
        let locals = hypothesis.locals.iter().map(|l| squares(l, local, Nuisance::is_unlimited));
        let cost = squares(&hypothesis.shared, shared, Nuisance::is_unlimited)
            + locals.sum::<f64>()
            + self.parameter_cost(hypothesis);
        if most > 0.0 { cost / most } else { 0.0 }
    }

    /// The 99.9 % quantile of the prior cost of the nuisances that have no limits if their priors are right; 0 if none
    /// has a prior.
    pub(crate) fn most_prior_cost(&self, hypothesis: &Hypothesis) -> f64 {
        let finite = |all: &[Nuisance]| {
            all.iter().filter(|n| n.deviation.is_finite() && n.is_unlimited()).count()
        };
        let count =
            finite(self.system.shared()) + hypothesis.locals.len() * finite(self.system.local());
        match count {
            0 => 0.0,
            _ => pam_numerics::statistics::chi_square_quantile(0.999, count as f64),
        }
    }

    /// `Σ (deviation / prior standard deviation)²` of the nuisances, and of parameters with a prior.
    pub(crate) fn prior_cost(&self, hypothesis: &Hypothesis) -> f64 {
        let (shared, local) = (self.system.shared(), self.system.local());
        let locals: f64 = hypothesis.locals.iter().map(|l| squares(l, local, |_| true)).sum();
        squares(&hypothesis.shared, shared, |_| true) + locals + self.parameter_cost(hypothesis)
    }

    /// The prior cost of parameters with a prior.
    fn parameter_cost(&self, hypothesis: &Hypothesis) -> f64 {
        let parameters = hypothesis.parameter_priors(self.system);
        parameters.iter().map(|[prior, value]| (value / prior).powi(2)).sum()
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
        // The first Jacobian comes with the residuals at the start.
        let linearised = if iterations > 0 { Some(self.jacobian(&start)?) } else { None };
        let errors = match &linearised {
            Some((_, residuals)) => self.errors_of_all(&start, residuals)?,
            None => self.errors(&start)?,
        };
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
        self.fit_from(fit, linearised, iterations)
    }

    /// Goes on with a fit for at most `iterations` steps.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the sensitivities cannot be simulated.
    pub fn fit_further(&self, fit: Fit, iterations: usize) -> Result<Fit, DiagnoseError> {
        self.fit_from(fit, None, iterations)
    }

    /// As [`fit_further`](Self::fit_further); the sensitivities at the present values may be known.
    fn fit_from(
        &self,
        mut fit: Fit,
        mut linearised: Option<(Jacobian, WhitenedResiduals)>,
        iterations: usize,
    ) -> Result<Fit, DiagnoseError> {
        for _ in 0..iterations {
            if fit.has_converged() {
                break;
            }
            let linearised = linearised.take().map_or_else(|| self.jacobian(&fit.hypothesis), Ok);
            self.improve(&mut fit, linearised?);
            if fit.has_converged() {
                self.compass_step(&mut fit);
            }
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

    /// One iteration: a step with the first damping that lowers the cost, then further steps with the same Jacobian while it
    /// predicts the drop of the cost (Shamanskii's method). The last drop is zero if no step lowers the cost, or if the linear
    /// model predicts too small a drop.
    fn improve(&self, fit: &mut Fit, (jacobian, residuals): (Jacobian, WhitenedResiduals)) {
        let settings = &self.settings.fit;
        let shared = self.system.shared();
        let equations = self.equations(&jacobian, &residuals, &fit.hypothesis, &fit.errors);
        fit.last_drop = 0.0;
        // The residuals after the step, and the drop of the cost over the predicted one.
        let mut moved = None;
        for _ in 0..settings.dampings_per_iteration {
            if let Some(step) = equations.step(fit.damping, shared) {
                let expected = equations.expected_drop(&step);
                if expected < fit.converged_drop {
                    return;
                }
                if let Some(residuals) = self.moves(fit, &step, 0.0) {
                    moved = Some((residuals, fit.last_drop / expected));
                    break;
                }
            }
            fit.damping *= settings.damping_after_failure;
        }
        let [low, high] = settings.jacobian_reuse_share;
        for _ in 0..self.jacobian_reuses {
            let Some((residuals, share)) = moved.take() else { break };
            if fit.has_converged() || !(low..high).contains(&share) {
                break;
            }
            let equations = self.equations(&jacobian, &residuals, &fit.hypothesis, &fit.errors);
            let Some(step) = equations.step(fit.damping, shared) else { break };
            let expected = equations.expected_drop(&step);
            if expected < fit.converged_drop {
                break;
            }
            let next = self.moves(fit, &step, low * expected);
            moved = next.map(|residuals| (residuals, fit.last_drop / expected));
            // Convergence is only declared with a Jacobian at the present values.
            fit.last_drop = fit.last_drop.max(fit.converged_drop);
        }
    }

    /// One step of a compass search (Kolda, Lewis and Torczon 2003) in the parameters of members with a [rugged](Candidates::is_rugged)
    /// cost, taken if it lowers the cost: gradient-based iterations stop at any of its local minima. Fits with the looser tolerance of the
    /// search try the largest step only.
    fn compass_step(&self, fit: &mut Fit) {
        let system = self.system;
        let rugged: Vec<usize> = (fit.hypothesis.fixed..fit.hypothesis.members.len())
            .filter(|&place| {
                let member = &fit.hypothesis.members[place];
                system.is_rugged(member.candidate, member.own())
            })
            .collect();
        let factors = self.settings.search.rugged_factors;
        let is_precise = fit.converged_drop <= self.settings.fit.converged_drop;
        for factor in factors.into_iter().take(if is_precise { factors.len() } else { 1 }) {
            let h = &fit.hypothesis;
            let scaled = |f: f64| rugged.iter().flat_map(move |&place| h.scaled(system, place, f));
            let others: Vec<Hypothesis> = scaled(factor).chain(scaled(1.0 / factor)).collect();
            let evaluated = parallel::map_each(others, |h| {
                let errors = self.errors(&h).ok()?;
                Some((self.cost(&h, &errors), errors, h))
            });
            let best = evaluated.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((cost, errors, h)) = best else { return };
            if cost < fit.cost - fit.converged_drop {
                fit.last_drop = fit.cost - cost;
                (fit.hypothesis, fit.errors, fit.cost) = (h, errors, cost);
                fit.damping = self.settings.fit.first_damping;
                return;
            }
        }
    }

    /// Takes a step if it lowers the cost by more than `least`; the whitened residuals after it.
    fn moves(&self, fit: &mut Fit, step: &[f64], least: f64) -> Option<WhitenedResiduals> {
        let settings = &self.settings.fit;
        let next = fit.hypothesis.moved(self.system, step, settings.largest_log_step);
        let (residuals, errors) = self.evaluated(&next).ok()?;
        let cost = self.cost(&next, &errors);
        if cost >= fit.cost - least || cost.is_nan() {
            return None;
        }
        fit.last_drop = fit.cost - cost;
        (fit.hypothesis, fit.errors, fit.cost) = (next, errors, cost);
        let less = fit.damping * settings.damping_after_success;
        fit.damping = less.max(settings.least_damping);
        Some(residuals)
    }
}
