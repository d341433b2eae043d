//! Experiments with the rows that count.

use super::hypothesis::Hypothesis;
use super::likelihood::ChannelErrors;
use super::normal::WhitenedResiduals;
use super::unseen::UnseenNuisances;
use crate::error::DiagnoseError;
use crate::noise::{Noise, correlated_rows};
use crate::search::{Candidates, OutputInfo};
use crate::settings::DiagnosisSettings;
use pam_core::parallel;
use pam_numerics::statistics::{root_mean_square, standard_deviation};
use std::ops::Range;
use std::sync::Arc;

/// Residuals of one experiment, and their derivatives (of the simulation) by every unknown: parameters of the
/// members, shared nuisances, the experiment's own nuisances.
#[derive(Debug, Clone)]
pub struct Sensitivities {
    /// Residuals of each fitted channel, row by row.
    pub residuals: Vec<Vec<f64>>,
    /// For each unknown and fitted channel one column of rows; empty where it is zero.
    pub columns: Vec<Vec<Vec<f64>>>,
}

/// Experiments and the rows of each that take part.
#[derive(Debug)]
pub struct Problem<'a, C: ?Sized> {
    /// The system with its candidates.
    pub system: &'a C,
    /// The settings.
    pub settings: &'a DiagnosisSettings,
    /// Indices of the experiments in the system.
    pub experiments: Vec<usize>,
    /// Grid points of each experiment that count, a whole number of rows.
    pub windows: Vec<Range<usize>>,
    /// The noise of the fitted channels.
    pub noise: Noise,
    /// Whitened rows that count as one independent observation: more than one where the residual of a model that is not
    /// right is correlated.
    pub rows_per_observation: f64,
    /// Most further steps of an iteration with the same Jacobian.
    pub(crate) jacobian_reuses: usize,
    /// What the nuisances of experiments that were not fitted would take, experiment by experiment.
    pub(crate) unseen: Option<Arc<Vec<Arc<UnseenNuisances>>>>,
}

impl<C: ?Sized> Clone for Problem<'_, C> {
    fn clone(&self) -> Self {
        Self {
            experiments: self.experiments.clone(),
            windows: self.windows.clone(),
            noise: self.noise.clone(),
            unseen: self.unseen.clone(),
            ..*self
        }
    }
}

impl<'a, C: Candidates + ?Sized> Problem<'a, C> {
    /// Experiments of a system between burn-in and burn-out.
    #[must_use]
    pub fn new(
        system: &'a C,
        experiments: Vec<usize>,
        noise: Noise,
        settings: &'a DiagnosisSettings,
    ) -> Self {
        let windows = experiments
            .iter()
            .map(|&e| {
                let most = settings.data.burn_in_share * system.points(e) as f64;
                let from = system.point_at(e, system.burn_in_s()).min(most as usize);
                let points = system.points(e);
                let end_s = system.time_s(e, points.max(1) - 1) - system.burn_out_s();
                let end =
                    if system.burn_out_s() > 0.0 { system.point_at(e, end_s) } else { points };
                whole_rows(from..end.max(from), system.points_per_row())
            })
            .collect();
        Self {
            system,
            settings,
            experiments,
            windows,
            noise,
            rows_per_observation: 1.0,
            jacobian_reuses: 0,
            unseen: None,
        }
    }

    /// The same experiments with other windows, each cut to whole rows. `window` gets the place of the experiment in
    /// the problem and its index in the system.
    #[must_use]
    pub fn with_windows(&self, window: impl Fn(usize, usize) -> Range<usize>) -> Self {
        let mut other = self.clone();
        for (i, (w, &e)) in other.windows.iter_mut().zip(&self.experiments).enumerate() {
            *w = whole_rows(window(i, e), self.system.points_per_row());
        }
        other
    }

    /// One experiment of the problem, in a part of its window.
    pub(crate) fn part(&self, place: usize, window: Range<usize>) -> Self {
        let window = whole_rows(window, self.system.points_per_row());
        Self {
            experiments: vec![self.experiments[place]],
            windows: vec![window],
            noise: self.noise.clone(),
            unseen: None,
            ..*self
        }
    }

    /// One experiment of the problem, with what its nuisances would take.
    pub(crate) fn one(&self, place: usize) -> Self {
        let mut one = self.part(place, self.windows[place].clone());
        one.unseen = self.unseen.as_ref().map(|all| Arc::new(vec![Arc::clone(&all[place])]));
        one
    }

    /// The experiments without one of them.
    pub(crate) fn others(&self, place: usize) -> Self {
        let mut others = Self { unseen: None, ..self.clone() };
        others.experiments.remove(place);
        others.windows.remove(place);
        others
    }

    /// Number of experiments.
    #[must_use]
    pub fn len(&self) -> usize {
        self.experiments.len()
    }

    /// Whether there are no experiments.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.experiments.is_empty()
    }

    /// Rows of an experiment.
    pub(crate) fn rows(&self, place: usize) -> usize {
        self.windows[place].len() / self.system.points_per_row()
    }

    /// Checks that every experiment has a row, for a role that the error names.
    ///
    /// # Errors
    /// [`DiagnoseError::TooLittle`] naming the first experiment without one.
    pub(crate) fn check_rows(&self, role: &str) -> Result<(), DiagnoseError> {
        let Some(place) = (0..self.len()).find(|&place| self.rows(place) == 0) else {
            return Ok(());
        };
        Err(DiagnoseError::TooLittle(format!(
            "recording `{}` has no row of {} grid points for {role} data between its first {} s and its last {} s; give longer \
             recordings, or other values of the settings `data`",
            self.system.name(self.experiments[place]),
            self.system.points_per_row(),
            self.system.burn_in_s(),
            self.system.burn_out_s()
        )))
    }

    /// Time between two rows of an experiment, s; infinite for a window without extent.
    pub(crate) fn row_s(&self, place: usize) -> f64 {
        let (e, w) = (self.experiments[place], &self.windows[place]);
        let span = self.system.time_s(e, w.end.max(1) - 1) - self.system.time_s(e, w.start);
        if w.len() < 2 || span <= 0.0 {
            return f64::INFINITY;
        }
        span / (w.len() - 1) as f64 * self.system.points_per_row() as f64
    }

    /// The [time between two rows](Self::row_s) of each experiment whose window has an extent, s.
    pub(crate) fn rows_s(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.len()).map(|i| self.row_s(i)).filter(|s| s.is_finite())
    }

    /// Rows in a block.
    pub(crate) fn rows_per_block(&self, place: usize) -> usize {
        self.system.rows_per_block(self.rows(place), self.row_s(place))
    }

    /// Blocks of rows that count as independent, over all experiments.
    #[must_use]
    pub fn blocks(&self) -> usize {
        (0..self.len()).map(|i| self.rows(i) / self.rows_per_block(i).max(1)).sum()
    }

    /// Rows in a block that is short enough for chance to be told from the blocks of all experiments together.
    pub(crate) fn rows_per_short_block(&self, place: usize) -> usize {
        let fewest = self.settings.rejection.fewest_blocks.div_ceil(self.len().max(1)).max(1);
        self.rows_per_block(place).min(self.rows(place) / fewest).max(1)
    }

    /// Root mean square of the deviations of a measured output from its mean in each experiment.
    pub(crate) fn variation(&self, output: usize) -> f64 {
        let deviation = |&e: &usize| standard_deviation(self.system.measured(e, output));
        let deviations: Vec<f64> = self.experiments.iter().map(deviation).collect();
        root_mean_square(&deviations)
    }

    /// The excitation in the middle of each row, experiment by experiment; empty without one.
    pub(crate) fn excitation_rows(&self) -> Vec<Vec<f64>> {
        let points = self.system.points_per_row();
        let of_experiment = |(&e, window): (&usize, &Range<usize>)| {
            let excitation = self.system.excitation(e);
            let rows = window.clone().step_by(points);
            rows.filter_map(|k| excitation.get(k + points / 2).copied()).collect()
        };
        self.experiments.iter().zip(&self.windows).map(of_experiment).collect()
    }

    /// Names of the experiments.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.experiments.iter().map(|&e| self.system.name(e).to_owned()).collect()
    }

    /// The hypothesis without any candidate and with all nuisances at zero.
    #[must_use]
    pub fn base(&self) -> Hypothesis {
        Hypothesis::base(self.system, self.len())
    }

    /// A hypothesis that was fitted to other experiments, with the nuisances of this problem's experiments at their prior means.
    #[must_use]
    pub fn with_base_locals(&self, hypothesis: &Hypothesis) -> Hypothesis {
        Hypothesis { locals: self.base().locals, ..hypothesis.clone() }
    }

    /// The simulated outputs of an experiment.
    pub(crate) fn simulate(
        &self,
        hypothesis: &Hypothesis,
        place: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let (e, until) = (self.experiments[place], self.windows[place].end);
        self.system.simulate(hypothesis, &hypothesis.locals[place], e, until)
    }

    /// Residuals (measured − simulated, row means) of the fitted channels of an experiment.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails.
    pub fn residuals(
        &self,
        hypothesis: &Hypothesis,
        place: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        Ok(self.residuals_of(&self.simulate(hypothesis, place)?, place))
    }

    /// The residuals of simulated outputs.
    pub(crate) fn residuals_of(&self, simulated: &[Vec<f64>], place: usize) -> Vec<Vec<f64>> {
        let (e, window) = (self.experiments[place], &self.windows[place]);
        fitted_outputs(self.system)
            .map(|(c, _)| {
                let rows = self.system.points_per_row();
                row_means(self.system.measured(e, c), &simulated[c], window.clone(), rows)
            })
            .collect()
    }

    /// Residuals of an experiment, whitened by the noise; of an experiment that was not fitted, less what its nuisances
    /// would take.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails.
    pub fn whitened_residuals(
        &self,
        hypothesis: &Hypothesis,
        place: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let white = self.whitened_as_fitted(hypothesis, place)?;
        Ok(match &self.unseen {
            Some(nuisances) => nuisances[place].cleared(white),
            None => white,
        })
    }

    /// Residuals of an experiment, whitened by the noise; nothing is taken off for nuisances that were not fitted.
    pub(super) fn whitened_as_fitted(
        &self,
        hypothesis: &Hypothesis,
        place: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let residuals = self.residuals(hypothesis, place)?;
        Ok(self.noise.whitened(self.experiments[place], &residuals))
    }

    /// Sums of the squared [whitened residuals](Self::whitened_residuals) of all channels over each
    /// [short block](Self::rows_per_short_block) of an experiment.
    pub(crate) fn squares_by_block(
        &self,
        hypothesis: &Hypothesis,
        place: usize,
    ) -> Result<Vec<f64>, DiagnoseError> {
        let white = self.whitened_residuals(hypothesis, place)?;
        Ok(self.products_by_block(&white, &white, place))
    }

    /// Sums of the products of two sets of whitened channels over each [short block](Self::rows_per_short_block) of an experiment.
    pub(crate) fn products_by_block(
        &self,
        a: &[Vec<f64>],
        b: &[Vec<f64>],
        place: usize,
    ) -> Vec<f64> {
        let block = self.rows_per_short_block(place);
        let product = |k: usize| -> f64 {
            let rows = k * block..(k + 1) * block;
            let pairs =
                a.iter().zip(b).flat_map(|(a, b)| a[rows.clone()].iter().zip(&b[rows.clone()]));
            pairs.map(|(a, b)| a * b).sum()
        };
        (0..self.rows(place) / block).map(product).collect()
    }

    /// Residuals and sensitivities of an experiment, whitened by the noise.
    pub(crate) fn whitened_sensitivities(
        &self,
        hypothesis: &Hypothesis,
        place: usize,
    ) -> Result<Sensitivities, DiagnoseError> {
        let (e, window) = (self.experiments[place], self.windows[place].clone());
        let s = self.system.sensitivities(hypothesis, &hypothesis.locals[place], e, window)?;
        Ok(self.whitened(e, &s))
    }

    /// As [`whitened_sensitivities`](Self::whitened_sensitivities), by the parameters alone.
    pub(crate) fn whitened_parameter_sensitivities(
        &self,
        hypothesis: &Hypothesis,
        place: usize,
    ) -> Result<Sensitivities, DiagnoseError> {
        let (e, window) = (self.experiments[place], self.windows[place].clone());
        let local = &hypothesis.locals[place];
        let s = self.system.parameter_sensitivities(hypothesis, local, e, window)?;
        Ok(self.whitened(e, &s))
    }

    fn whitened(&self, experiment: usize, s: &Sensitivities) -> Sensitivities {
        let white = |rows: &Vec<Vec<f64>>| self.noise.whitened(experiment, rows);
        Sensitivities {
            residuals: white(&s.residuals),
            columns: s.columns.iter().map(white).collect(),
        }
    }

    /// The prior cost of what the nuisances of an experiment that was not fitted take; 0 for one that was.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails.
    pub(crate) fn unseen_prior_cost(
        &self,
        hypothesis: &Hypothesis,
        place: usize,
    ) -> Result<f64, DiagnoseError> {
        let Some(nuisances) = &self.unseen else { return Ok(0.0) };
        Ok(nuisances[place].prior_cost(&self.whitened_as_fitted(hypothesis, place)?))
    }

    /// The same experiments as ones whose nuisances are not fitted: what those of `base` would take counts as no error.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails.
    pub(crate) fn as_unseen(&self, base: &Hypothesis) -> Result<Self, DiagnoseError> {
        let plain = Self { unseen: None, ..self.clone() };
        let base = Hypothesis { members: Vec::new(), fixed: 0, ..base.clone() };
        let each: Result<Vec<Arc<UnseenNuisances>>, DiagnoseError> =
            parallel::map(self.len(), |i| {
                let s = plain.whitened_sensitivities(&base, i)?;
                let locals = s.columns[self.system.shared().len()..].to_vec();
                Ok(Arc::new(UnseenNuisances::new(locals, self.system.local())))
            })
            .into_iter()
            .collect();
        Ok(Self { unseen: Some(Arc::new(each?)), ..plain })
    }

    /// The same experiments as ones whose nuisances are fitted.
    pub(crate) fn as_fitted(&self) -> Self {
        Self { unseen: None, ..self.clone() }
    }

    /// Errors of all experiments together, whitened.
    ///
    /// # Errors
    /// [`DiagnoseError`] of the first experiment whose simulation fails.
    pub fn errors(&self, hypothesis: &Hypothesis) -> Result<ChannelErrors, DiagnoseError> {
        Ok(self.evaluated(hypothesis)?.1)
    }

    /// The [whitened residuals](Self::whitened_as_fitted) of all experiments, and their errors.
    ///
    /// # Errors
    /// [`DiagnoseError`] of the first experiment whose simulation fails.
    pub(super) fn evaluated(
        &self,
        hypothesis: &Hypothesis,
    ) -> Result<(WhitenedResiduals, ChannelErrors), DiagnoseError> {
        let each = parallel::map(self.len(), |i| {
            let white = self.whitened_as_fitted(hypothesis, i)?;
            let errors = self.errors_of(hypothesis, &white, i)?;
            Ok((white, errors))
        });
        let each: Result<Vec<_>, DiagnoseError> = each.into_iter().collect();
        let (residuals, errors): (_, Vec<ChannelErrors>) = each?.into_iter().unzip();
        Ok((residuals, self.together(errors)))
    }

    /// The errors of the [whitened residuals](Self::whitened_as_fitted) of a hypothesis.
    ///
    /// # Errors
    /// [`DiagnoseError`] of the first experiment whose simulation fails.
    pub(super) fn errors_of_all(
        &self,
        hypothesis: &Hypothesis,
        residuals: &WhitenedResiduals,
    ) -> Result<ChannelErrors, DiagnoseError> {
        let each = residuals.iter().enumerate();
        let each = each.map(|(i, white)| self.errors_of(hypothesis, white, i));
        Ok(self.together(each.collect::<Result<_, _>>()?))
    }

    fn together(&self, each: Vec<ChannelErrors>) -> ChannelErrors {
        let none = ChannelErrors { sums: vec![0.0; self.noise.channels()], rows: 0 };
        each.iter().fold(none, |sum, e| sum.and(e))
    }

    /// The errors of one experiment. What nuisances take of rows that were not fitted costs what it is worth.
    fn errors_of(
        &self,
        hypothesis: &Hypothesis,
        white: &[Vec<f64>],
        place: usize,
    ) -> Result<ChannelErrors, DiagnoseError> {
        let square = |r: &Vec<f64>| r.iter().map(|v| v * v).sum::<f64>();
        let sums = match &self.unseen {
            None => white.iter().map(square).collect(),
            Some(nuisances) => {
                let cleared = nuisances[place].cleared(white.to_vec());
                let prior = self.unseen_prior_cost(hypothesis, place)?;
                let prior = prior / cleared.len().max(1) as f64;
                cleared.iter().map(|r| square(r) + prior).collect()
            }
        };
        Ok(ChannelErrors { sums, rows: self.rows(place) })
    }

    /// Whitened rows over which the residual of a hypothesis is correlated, the most of its channels. 1 where the
    /// hypothesis leaves nothing but noise.
    ///
    /// # Errors
    /// [`DiagnoseError`] of the first experiment whose simulation fails.
    pub fn correlated_rows(&self, hypothesis: &Hypothesis) -> Result<f64, DiagnoseError> {
        let each: Result<Vec<Vec<f64>>, DiagnoseError> = parallel::map(self.len(), |i| {
            let residuals = self.whitened_residuals(hypothesis, i)?;
            let settings = &self.settings.noise;
            Ok(residuals.iter().map(|r| correlated_rows(r, settings) * r.len() as f64).collect())
        })
        .into_iter()
        .collect();
        let rows: usize = (0..self.len()).map(|i| self.rows(i)).sum();
        let mut sums = vec![0.0; self.noise.channels()];
        for own in each? {
            sums.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        }
        Ok(sums.into_iter().map(|s| s / rows.max(1) as f64).fold(1.0, f64::max))
    }
}

/// The fitted outputs of a system with their indices.
pub(crate) fn fitted_outputs<C: Candidates + ?Sized>(
    system: &C,
) -> impl Iterator<Item = (usize, &OutputInfo)> {
    system.outputs().iter().enumerate().filter(|(_, o)| o.fitted)
}

fn whole_rows(range: Range<usize>, points_per_row: usize) -> Range<usize> {
    let rows = range.len() / points_per_row;
    range.start..range.start + rows * points_per_row
}

/// Means of `measured − simulated` over each row of a window.
pub(crate) fn row_means(
    measured: &[f64],
    simulated: &[f64],
    window: Range<usize>,
    points_per_row: usize,
) -> Vec<f64> {
    let pairs = measured[window.clone()].chunks_exact(points_per_row);
    pairs
        .zip(simulated[window].chunks_exact(points_per_row))
        .map(|(m, s)| {
            let sum: f64 = m.iter().zip(s).map(|(m, s)| m - s).sum();
            sum / points_per_row as f64
        })
        .collect()
}
