//! A fitted hypothesis with its score.

use super::candidates::Candidates;
use crate::data::Split;
use crate::fit::{ChannelErrors, Fit, Hypothesis, Problem};

/// A fitted hypothesis with its errors on the validation rows.
#[derive(Debug, Clone)]
pub struct Scored {
    /// The fit to the training rows.
    pub fit: Fit,
    /// Errors on the validation rows.
    pub validation: ChannelErrors,
    /// `n Σ_c g(MSE_c)` of training and validation rows ([`ChannelErrors::deviance_above`]): minus two times the
    /// log-likelihood if every row is an observation.
    pub misfit: f64,
    /// Cost of the hypothesis independent of the data: priors of its nuisances, `p ln n` for `p` parameters (Schwarz 1978),
    /// `2 ln K` for the choice of each member among `K` candidates, and the cost of scales at their limits.
    pub price: f64,
    /// Whitened rows over which what it leaves of the training rows is correlated: so many count as one observation.
    pub rows_per_observation: f64,
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

    /// Minus two times the logarithm of the posterior probability, up to a constant, if so many rows are one observation.
    #[must_use]
    pub fn total(&self, rows_per_observation: f64) -> f64 {
        self.misfit / rows_per_observation + self.price
    }

    /// The logarithm of the odds against another fitted set: half the difference of their [totals](Self::total), with as many
    /// rows to an observation as this one's residual is correlated over. So a set that leaves noise is compared with the full
    /// weight of all rows, and one that leaves an unexplained motion is not, as its errors repeat.
    #[must_use]
    pub fn log_odds(&self, against: &Self) -> f64 {
        let rows = self.rows_per_observation;
        0.5 * (against.total(rows) - self.total(rows))
    }

    /// Normalised χ² of training and validation rows.
    #[must_use]
    pub fn chi_square(&self) -> f64 {
        self.fit.errors.and(&self.validation).chi_square()
    }
}

/// Scores a fit on the validation rows; `None` if the simulation fails there.
#[must_use]
pub(super) fn score<C: Candidates + ?Sized>(split: &Split<'_, C>, fit: Fit) -> Option<Scored> {
    let validation = split.validation_errors(&fit.hypothesis).ok()?;
    let problem = &split.train;
    let own = problem.noise.discrepancy_levels();
    let rows = |e: &ChannelErrors| e.rows as f64 * e.deviance_above(own);
    let misfit = rows(&fit.errors) + rows(&validation);
    let price = problem.prior_cost(&fit.hypothesis) + complexity(split, &fit);
    let rows_per_observation = problem.correlated_rows(&fit.hypothesis).ok()?;
    Some(Scored { misfit, price, rows_per_observation, validation, fit })
}

/// The price of the parameters of a fit, of the choice of its members, and of scales at their limits.
#[must_use]
pub(super) fn complexity<C: Candidates + ?Sized>(split: &Split<'_, C>, fit: &Fit) -> f64 {
    let problem = &split.train;
    let of = |p: &Problem<'_, C>| (0..p.len()).map(|i| p.rows(i)).sum::<usize>();
    let observations = (of(problem) + of(&split.validation)).max(2) as f64;
    let parameters = fit.hypothesis.parameters(problem.system).len() as f64;
    let members = (fit.hypothesis.members.len() - fit.hypothesis.fixed) as f64;
    let choice = 2.0 * members * (problem.system.candidate_len().max(1) as f64).ln();
    let limits = problem.settings.search.limit_cost * fit.scales_at_limit as f64;
    parameters * observations.ln() + choice + limits
}
