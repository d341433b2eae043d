//! The interface between the inference and the system that it is applied to.

use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Sensitivities};
use pam_vocabulary::ParameterInfo;
use std::ops::Range;

/// A possible cause.
#[derive(Debug, Clone, Copy)]
pub struct CandidateInfo<'a> {
    /// Its id.
    pub id: &'a str,
    /// Short description.
    pub description: &'a str,
    /// Which excitation brings it out; may be empty.
    pub excited_by: &'a str,
    /// Its fitted parameters.
    pub parameters: &'a [ParameterInfo],
    /// Number of its values: parameters, then switches that are not fitted.
    pub value_len: usize,
}

/// A measured channel.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputInfo {
    /// Key in files.
    pub key: String,
    /// Name in sentences.
    pub name: String,
    /// Unit of its values.
    pub unit: String,
    /// Whether its residual is fitted. A derivative of another output carries nothing of its own.
    pub fitted: bool,
}

/// An uncertain value that is fitted along with every hypothesis, as deviation from its measured or given value, with a
/// Gaussian prior of mean zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nuisance {
    /// Standard deviation of the prior; infinite for a value that is free.
    pub deviation: f64,
    /// Least and greatest deviation.
    pub limits: [f64; 2],
}

impl Nuisance {
    /// A nuisance value without limits.
    #[must_use]
    pub fn of(deviation: f64) -> Self {
        Self { deviation, limits: [f64::NEG_INFINITY, f64::INFINITY] }
    }

    /// True for an unbounded nuisance.
    pub(crate) fn is_unlimited(&self) -> bool {
        self.limits == [f64::NEG_INFINITY, f64::INFINITY]
    }

    /// By how much the deviations of nuisances would have to be wider for the values of experiments: for each nuisance
    /// the root mean square of `value / deviation`, at least 1.
    pub(crate) fn widenings(nuisances: &[Self], experiments: &[Vec<f64>]) -> Vec<f64> {
        let of = |(k, nuisance): (usize, &Self)| {
            let square = |values: &Vec<f64>| (values[k] / nuisance.deviation).powi(2);
            let sum: f64 = experiments.iter().map(square).sum();
            (sum / experiments.len().max(1) as f64).sqrt().max(1.0)
        };
        nuisances.iter().enumerate().map(of).collect()
    }

    /// Makes the deviations of nuisances wider.
    pub(crate) fn widen(nuisances: &mut [Self], factors: &[f64]) {
        nuisances.iter_mut().zip(factors).for_each(|(n, factor)| n.deviation *= factor);
    }
}

/// A system with possible causes, and the experiments in which one of them may be at work.
///
/// Experiments are sampled on grid points; windows are ranges of grid points; [`points_per_row`] points are averaged
/// into one row of residuals `measured − simulated`. `local` are the values of the experiment's own nuisances.
///
/// [`points_per_row`]: Self::points_per_row
pub trait Candidates: Sync {
    /// Number of candidates.
    fn candidate_len(&self) -> usize;
    /// A candidate by its index.
    fn candidate(&self, index: usize) -> CandidateInfo<'_>;
    /// Values from which a fit of the candidate starts. The derivative by an amplitude must not vanish there.
    fn starts(&self, index: usize) -> Vec<Vec<f64>>;
    /// Whether fitted values are still what the candidate's name says.
    fn stands(&self, index: usize, values: &[f64]) -> bool {
        let _ = (index, values);
        true
    }
    /// Returns true if a candidate may still act when all its magnitudes have their off values.
    fn acts_where_off(&self, index: usize) -> bool {
        let _ = index;
        false
    }
    /// Returns true if the cost has many local minima as a function of the candidate's parameters. Its fits then end with a compass search.
    fn is_rugged(&self, index: usize, values: &[f64]) -> bool {
        let _ = (index, values);
        false
    }

    /// Standard deviation of the Gaussian prior of a fitted parameter about the value at which it is absent; infinite for one
    /// that is free, as those of causes are. The coefficients of a flexible term have one.
    fn parameter_deviation(&self, candidate: usize, parameter: usize) -> f64 {
        let _ = (candidate, parameter);
        f64::INFINITY
    }

    /// Whether a member of the candidate may have a [schedule](crate::onset::Schedule): whether simulations follow it.
    fn may_be_timed(&self, index: usize) -> bool {
        let _ = index;
        false
    }

    /// Whether the candidate changes what readings before the first row mean, so that one that begins with the first row differs
    /// from one that is always there.
    fn acts_at_rest(&self, index: usize) -> bool {
        let _ = index;
        true
    }

    /// Time in which a member with a schedule comes or goes, s.
    fn ramp_s(&self) -> f64 {
        pam_vocabulary::course::LEAST_RAMP_S
    }

    /// Uncertain values that all experiments share.
    fn shared(&self) -> &[Nuisance];
    /// Place among the shared uncertain values of the time at which the excitation acts between its samples, in samples and with limits;
    /// none where the excitation is known at all times.
    fn timing(&self) -> Option<usize> {
        None
    }
    /// Uncertain values of each experiment.
    fn local(&self) -> &[Nuisance];

    /// Number of experiments.
    fn experiment_len(&self) -> usize;
    /// The measured channels.
    fn outputs(&self) -> &[OutputInfo];
    /// Name of an experiment.
    fn name(&self, experiment: usize) -> &str;
    /// Number of grid points of an experiment.
    fn points(&self, experiment: usize) -> usize;
    /// Number of grid points at which an experiment is simulated where those before `until` are asked for. It must not decrease
    /// with `until`; the same simulation serves all that have the same.
    fn simulated_points(&self, experiment: usize, until: usize) -> usize {
        let _ = until;
        self.points(experiment)
    }
    /// Integration steps of a simulation where the grid points before `until` are asked for: a measure of what it takes.
    fn steps(&self, experiment: usize, until: usize) -> usize {
        self.simulated_points(experiment, until)
    }
    /// Time of a grid point since the first, s.
    fn time_s(&self, experiment: usize, point: usize) -> f64;
    /// Time of the first grid point in the recording, s.
    fn start_s(&self, experiment: usize) -> f64 {
        let _ = experiment;
        0.0
    }
    /// The grid point at a time since the first, or a neighbour of that time; at most the number of points, which an
    /// infinite time gives. It must not decrease with the time.
    fn point_at(&self, experiment: usize, time_s: f64) -> usize;
    /// A measured channel at the grid points.
    fn measured(&self, experiment: usize, output: usize) -> &[f64];
    /// The step of the sensor of a channel, in its unit; 0 where its values show none.
    fn resolution(&self, experiment: usize, output: usize) -> f64 {
        let _ = (experiment, output);
        0.0
    }
    /// Grid points that are averaged into one row.
    fn points_per_row(&self) -> usize {
        1
    }
    /// Time from the start that is not fitted, s.
    fn burn_in_s(&self) -> f64 {
        0.0
    }
    /// Time up to the end that is not fitted, s: where a zero-phase filter has no samples to come.
    fn burn_out_s(&self) -> f64 {
        0.0
    }
    /// Rows in a block, for clustered covariances, the null test and the bootstrap, if the window has so many `rows`
    /// that are `row_s` apart.
    fn rows_per_block(&self, rows: usize, row_s: f64) -> usize;

    /// All outputs of an experiment under a hypothesis at the grid points, at those before `until` at least.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails.
    fn simulate(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        until: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError>;

    /// Residuals and their sensitivities in a window. Fitted parameters that are logarithmic are differentiated by
    /// their logarithm.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails.
    fn sensitivities(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Sensitivities, DiagnoseError>;

    /// As [`sensitivities`](Self::sensitivities), with the columns of the parameters alone. Implement it where that takes less
    /// time.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails.
    fn parameter_sensitivities(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Sensitivities, DiagnoseError> {
        let mut all = self.sensitivities(hypothesis, local, experiment, window)?;
        all.columns.truncate(all.columns.len() - self.shared().len() - self.local().len());
        Ok(all)
    }

    /// Features from which a flexible model learns the residual, at the grid points of the `simulated` outputs.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails.
    fn features(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        simulated: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, DiagnoseError>;

    /// Names and units of the factors that a residual may depend on.
    fn factor_names(&self) -> Vec<(String, String)>;
    /// The factors at the rows of a window.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails.
    fn factors(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError>;

    /// Name of the excitation with its unit, for axes of figures.
    fn excitation_label(&self) -> String;
    /// The excitation at the grid points; empty without one.
    fn excitation(&self, experiment: usize) -> Vec<f64>;
    /// Stretches of a window with an excitation of their own, by name: those of one frequency of the excitation.
    fn strata(&self, experiment: usize, window: Range<usize>) -> Vec<(String, Range<usize>)> {
        let excitation = self.excitation(experiment);
        let Some(excitation) = excitation.get(window.clone()).filter(|e| !e.is_empty()) else {
            return vec![("all".into(), window)];
        };
        let times: Vec<f64> = window.clone().map(|k| self.time_s(experiment, k)).collect();
        pam_train::frequency_segments(&times, excitation)
            .into_iter()
            .map(|s| (s.label(), window.start + s.range.start..window.start + s.range.end))
            .collect()
    }
}
