//! The fit of a hypothesis by Levenberg–Marquardt.

use super::hypothesis::Hypothesis;
use super::likelihood::ChannelErrors;
use super::problem::Problem;
use crate::error::DiagnoseError;
use crate::search::{Candidates, Nuisance};

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
}

impl Fit {
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

    /// `Σ (deviation / prior standard deviation)²` of the nuisances.
    pub(crate) fn prior_cost(&self, hypothesis: &Hypothesis) -> f64 {
        let cost = |values: &[f64], nuisances: &[Nuisance]| -> f64 {
            values.iter().zip(nuisances).map(|(d, n)| (d / n.deviation).powi(2)).sum()
        };
        let locals: f64 = hypothesis.locals.iter().map(|l| cost(l, self.system.local())).sum();
        cost(&hypothesis.shared, self.system.shared()) + locals
    }

    /// Moves a hypothesis towards its best fit in at most `iterations` steps.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails at the start.
    pub fn fit(&self, start: Hypothesis, iterations: usize) -> Result<Fit, DiagnoseError> {
        let settings = &self.settings.fit;
        let mut best = start;
        let mut errors = self.errors(&best)?;
        let mut cost = self.cost(&best, &errors);
        let mut damping = settings.first_damping;
        let mut last_drop = f64::INFINITY;
        for _ in 0..iterations {
            let equations = self.normal_equations(&best, &errors)?;
            let mut drop = 0.0;
            for _ in 0..settings.dampings_per_iteration {
                let step = equations.step(damping, self.system.shared());
                let moved = step.map(|s| best.moved(self.system, &s, settings.largest_log_step));
                let tried = moved.and_then(|h| self.errors(&h).ok().map(|e| (h, e)));
                if let Some((next, next_errors)) = tried {
                    let next_cost = self.cost(&next, &next_errors);
                    if next_cost < cost {
                        drop = cost - next_cost;
                        (best, errors, cost) = (next, next_errors, next_cost);
                        damping =
                            (damping * settings.damping_after_success).max(settings.least_damping);
                        break;
                    }
                }
                damping *= settings.damping_after_failure;
            }
            last_drop = drop;
            if drop < settings.converged_drop {
                break;
            }
        }
        let parameters = best.parameters(self.system);
        let limited: Vec<_> = parameters
            .iter()
            .filter(|p| {
                let [low, high] = p.info.range;
                let margin = 1e-9 * (high - low);
                let value = best.members[p.member].values[p.value];
                value <= low + margin || value >= high - margin
            })
            .collect();
        let scales_at_limit = limited.iter().filter(|p| p.info.logarithmic).count();
        let at_limit = limited.iter().map(|p| p.info.name).collect();
        Ok(Fit { hypothesis: best, errors, cost, at_limit, scales_at_limit, last_drop })
    }
}
