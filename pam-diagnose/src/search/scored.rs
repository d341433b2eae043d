//! A fitted hypothesis with its score.

use super::candidates::Candidates;
use crate::data::Split;
use crate::fit::{ChannelErrors, Fit, Hypothesis};
use crate::settings::SearchSettings;

/// A fitted hypothesis with its errors on the validation rows.
#[derive(Debug, Clone)]
pub struct Scored {
    /// The fit to the training rows.
    pub fit: Fit,
    /// Errors on the validation rows.
    pub validation: ChannelErrors,
    /// Minus two times the log-likelihood of all rows, with the priors, the complexity `p ln n` of `p` parameters and
    /// the cost of scales at their limits.
    pub total: f64,
}

impl Scored {
    /// The hypothesis.
    #[must_use]
    pub fn hypothesis(&self) -> &Hypothesis {
        &self.fit.hypothesis
    }

    /// Number of members.
    #[must_use]
    pub fn members(&self) -> usize {
        self.fit.hypothesis.members.len()
    }

    /// Normalised χ² of training and validation rows.
    #[must_use]
    pub fn chi_square(&self, noise: &[f64]) -> f64 {
        self.fit.errors.and(&self.validation).chi_square(noise)
    }

    /// Whether this hypothesis is better than another by the drops of deviance and total cost that `causes` further
    /// causes must be worth, times a `factor`.
    pub(super) fn earns(
        &self,
        over: &Self,
        noise: &[f64],
        settings: &SearchSettings,
        factor: f64,
    ) -> bool {
        let drop = over.validation.deviance(noise) - self.validation.deviance(noise);
        drop >= settings.validation_drop * factor
            && over.total - self.total >= settings.total_drop * factor
    }
}

/// Scores a fit on the validation rows; `None` if the simulation fails there.
#[must_use]
pub(crate) fn score<C: Candidates + ?Sized>(split: &Split<'_, C>, fit: Fit) -> Option<Scored> {
    let validation = split.validation_errors(&fit.hypothesis).ok()?;
    let problem = &split.train;
    let rows_per_observation = problem.system.rows_per_observation();
    let observations = (fit.errors.rows + validation.rows) as f64 / rows_per_observation;
    let parameters = fit.hypothesis.parameters(problem.system).len();
    let complexity = parameters as f64 * observations.max(2.0).ln();
    let validated =
        validation.rows as f64 / rows_per_observation * validation.deviance(&problem.noise);
    let limits = problem.settings.search.limit_cost * fit.scales_at_limit as f64;
    Some(Scored { total: fit.cost + validated + complexity + limits, validation, fit })
}

/// The system without candidates, with its nuisances fitted; `None` if the simulation fails.
#[must_use]
pub fn fit_base<C: Candidates + ?Sized>(split: &Split<'_, C>) -> Option<Scored> {
    let problem = &split.train;
    let fit = problem.fit(problem.base(), problem.settings.search.iterations).ok()?;
    score(split, fit)
}

/// Drops the member at `place` and refits the others; `None` if the simulation fails.
#[must_use]
pub(crate) fn refit_without<C: Candidates + ?Sized>(
    split: &Split<'_, C>,
    scored: &Scored,
    place: usize,
    iterations: usize,
) -> Option<Scored> {
    score(split, split.train.fit(scored.hypothesis().without(place), iterations).ok()?)
}
