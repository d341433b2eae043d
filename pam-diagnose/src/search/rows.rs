//! The rows of a search, in units of a noise that is learned anew as the search goes on.

use super::candidates::Candidates;
use super::scored::{Scored, score};
use crate::data::{Roles, Split};
use crate::fit::{Fit, Hypothesis, Problem};
use crate::noise::{Discrepancy, Noise, NoisePrior};
use crate::settings::DiagnosisSettings;

/// Training and validation rows, apart and together.
#[derive(Debug)]
pub struct Rows<'a, C: ?Sized> {
    /// Training rows, to which hypotheses are fitted, and validation rows, by which they are chosen as well.
    pub choosing: Split<'a, C>,
    /// Both together, all fitted.
    pub whole: Problem<'a, C>,
    prior: NoisePrior,
}

impl<'a, C: Candidates + ?Sized> Rows<'a, C> {
    /// Rows of which so much is known beforehand.
    #[must_use]
    pub fn new(choosing: Split<'a, C>, whole: Problem<'a, C>, prior: NoisePrior) -> Self {
        Self { choosing, whole, prior }
    }

    /// The rows that train and validate by their roles, in units of a first noise.
    #[must_use]
    pub fn of(
        roles: &Roles,
        system: &'a C,
        noise: &Noise,
        prior: NoisePrior,
        settings: &'a DiagnosisSettings,
    ) -> Self {
        let choosing = roles.split(system, noise, settings);
        Self::new(choosing, roles.whole(system, noise, settings), prior)
    }

    /// Takes the noise beside a set as the unit of all errors, and the correlation of what the set leaves as the number of
    /// rows that are one observation. Returns the set fitted to all rows; `None` if it cannot be simulated.
    pub fn learn_beside(&mut self, set: &Hypothesis) -> Option<Fit> {
        let iterations = self.whole.settings.search.iterations;
        let fit = self.whole.fit(self.whole.with_base_locals(set), iterations).ok()?;
        let noise = Noise::learned(&self.whole, &fit.hypothesis, &self.prior)?;
        self.set_noise(&noise, &fit.hypothesis)?;
        self.whole.fit(fit.hypothesis, iterations).ok()
    }

    /// The knowledge of the noise with further errors of the model.
    pub(crate) fn prior_with(&self, discrepancy: &Discrepancy) -> NoisePrior {
        let mut prior = self.prior.clone();
        prior.discrepancy.add(discrepancy);
        prior
    }

    /// Takes a noise as the unit of all errors, and the correlation of what a fitted set leaves as the number of rows that are
    /// one observation; `None` if the set cannot be simulated.
    pub(crate) fn set_noise(&mut self, noise: &Noise, set: &Hypothesis) -> Option<()> {
        self.whole.noise = noise.clone();
        let rows_per_observation = self.whole.correlated_rows(set).ok()?;
        self.whole.rows_per_observation = rows_per_observation;
        let Split { train, validation, same_experiments } = &mut self.choosing;
        for problem in [train, &mut *validation] {
            problem.noise = noise.clone();
            problem.rows_per_observation = rows_per_observation;
        }
        if !*same_experiments {
            let base = Hypothesis { shared: set.shared.clone(), ..validation.base() };
            *validation = validation.as_unseen(&base).ok()?;
        }
        Some(())
    }

    /// Takes so many rows as one observation.
    pub(crate) fn set_rows_per_observation(&mut self, rows: f64) {
        let Split { train, validation, .. } = &mut self.choosing;
        for problem in [&mut self.whole, train, validation] {
            problem.rows_per_observation = rows;
        }
    }

    /// Lets an iteration of a fit take so many further steps with the same Jacobian.
    pub(crate) fn set_jacobian_reuses(&mut self, steps: usize) {
        let Split { train, validation, .. } = &mut self.choosing;
        for problem in [&mut self.whole, train, validation] {
            problem.jacobian_reuses = steps;
        }
    }

    /// A set of starting values fitted to the training rows and scored; `None` if it cannot be simulated, or if a fitted
    /// value is not what the candidate's name says.
    #[must_use]
    pub fn fitted(&self, start: Hypothesis, iterations: usize) -> Option<Scored> {
        self.scored(self.choosing.train.fit(start, iterations).ok()?)
    }

    /// A fit to the training rows, scored; `None` if it cannot be simulated on the validation rows, or if a fitted value is
    /// not what the candidate's name says.
    pub(crate) fn scored(&self, fit: Fit) -> Option<Scored> {
        super::stands(self.whole.system, &fit.hypothesis).then(|| score(&self.choosing, fit))?
    }

    /// The logarithm of the odds that a further cause must reach. Where there are few blocks, nothing but the noise model
    /// vouches for the independence of the rows, so more is asked.
    #[must_use]
    pub fn needed_log_odds(&self) -> f64 {
        let settings = &self.whole.settings.search;
        let few = self.whole.blocks() < self.whole.settings.rejection.fewest_blocks;
        if few { settings.odds_of_few_blocks.ln() } else { settings.odds.ln() }
    }
}
