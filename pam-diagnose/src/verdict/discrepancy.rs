//! What the model's own errors add to the intervals of named causes.
//!
//! Errors of a model repeat with the motion, in all recordings alike. So no scatter of residuals between blocks or recordings
//! shows what they do to a parameter that they look like, and more data make an interval shorter and not right (Brynjarsdóttir and
//! O'Hagan 2014). The error of each channel is a sum of features `φ` of the motion with independent coefficients of mean zero, of which
//! each has the same part of the variance, and each coefficient moves the parameters by `H⁻¹ Jᵀ W φ`.
//!
//! [`known_errors`] have the size that baseline recordings show; names are tested against them. Without baseline recordings, or beside
//! a cause that is not named, the errors are larger: [`widen_by_unexplained`] estimates their size from the residual and widens the
//! intervals of the named causes.

use super::cause::Cause;
use crate::fit::{Fit, HALF_WIDTH, Problem, Responses};
use crate::residual::flexible::FeatureRows;
use crate::search::Candidates;
use pam_numerics::statistics::{root_mean_square, t_quantile_95};

/// By how much errors of the model, each by one standard deviation, move the fitted parameters.
pub(crate) struct ModelErrors {
    /// For each fitted parameter, in the coordinate in which it is fitted, one value for each error.
    moved: Vec<Vec<f64>>,
}

impl ModelErrors {
    /// Errors of which those of each channel together have a standard deviation.
    fn of(responses: &Responses, deviations: &[f64], parameters: usize) -> Self {
        let count = responses.moved.len() / deviations.len().max(1);
        let of_parameter = |p: usize| {
            let each = responses.moved.iter().enumerate();
            each.map(|(k, moved)| deviations[k / count] * moved[p]).collect()
        };
        Self { moved: (0..parameters).map(of_parameter).collect() }
    }

    /// Half the 95 % interval that they give a parameter.
    pub(crate) fn half_width(&self, parameter: usize) -> f64 {
        HALF_WIDTH * self.covariance(parameter, parameter).sqrt()
    }

    /// The covariance that they give two parameters.
    pub(crate) fn covariance(&self, i: usize, j: usize) -> f64 {
        self.moved[i].iter().zip(&self.moved[j]).map(|(a, b)| a * b).sum()
    }
}

/// The changes of the fitted parameters by errors that the model is [known](crate::noise::Noise::discrepancy) to make; none if the
/// simulation of the fit fails.
pub(crate) fn known_errors<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    fit: &Fit,
) -> ModelErrors {
    let parameters = fit.hypothesis.parameters(problem.system).len();
    let deviations: Vec<f64> =
        (0..problem.noise.channels()).map(|c| problem.noise.discrepancy(c)).collect();
    match responses(problem, fit, |_| 1) {
        Some(responses) => ModelErrors::of(&responses, &deviations, parameters),
        None => ModelErrors { moved: vec![Vec::new(); parameters] },
    }
}

/// Widens the intervals of causes by the model errors that the residual of their fit shows beyond the noise and the known errors. The ends
/// stay within the range of the parameter. The intervals are unchanged if the residual is within the noise or the simulation fails.
pub(crate) fn widen_by_unexplained<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    fit: &Fit,
    causes: &mut [Cause],
) {
    let mean_squares = fit.errors.mean();
    if causes.is_empty() || mean_squares.iter().all(|m| *m <= 1.0) {
        return;
    }
    let Some(responses) = responses(problem, fit, |features| features) else { return };
    let observations = fit.errors.rows as f64 / problem.rows_per_observation;
    let deviations = unexplained_deviations(&responses, &mean_squares, observations);
    let parameters = fit.hypothesis.parameters(problem.system);
    let errors = ModelErrors::of(&responses, &deviations, parameters.len());
    for (k, fitted) in parameters.iter().enumerate() {
        let (candidate, info) = (fit.hypothesis.members[fitted.member].candidate, fitted.info);
        // Intervals of times come from the likelihood itself.
        let is_time = fitted.value >= problem.system.candidate(candidate).parameters.len();
        let cause = causes.iter_mut().find(|c| c.member.candidate == candidate && !is_time);
        if let Some((_, interval)) = cause.and_then(|c| c.parameters.get_mut(fitted.value)) {
            *interval = interval.widened(errors.half_width(k), info);
            interval.ci95 = interval.ci95.map(|end| end.clamp(info.range[0], info.range[1]));
        }
    }
}

/// The response of a fit to errors of each channel in the shape of each feature. The features are scaled so that their mean squares add up
/// to 1. `group` maps the number of features to the size of the groups of [`Responses::left`].
fn responses<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    fit: &Fit,
    group: impl Fn(usize) -> usize,
) -> Option<Responses> {
    let rows = FeatureRows::gather(problem, &fit.hypothesis)?;
    let (channels, count) = (problem.noise.channels(), rows.features.len());
    let scale = |f: &Vec<f64>| {
        let size = root_mean_square(f) * (count as f64).sqrt();
        if size > 0.0 { 1.0 / size } else { 0.0 }
    };
    let scales: Vec<f64> = rows.features.iter().map(scale).collect();
    let series = |i: usize| -> Vec<Vec<Vec<f64>>> {
        let range = rows.experiments[i].clone();
        (0..channels * count)
            .map(|k| {
                let (c, f) = (k / count, k % count);
                let mut all = vec![Vec::new(); channels];
                all[c] = rows.features[f][range.clone()].iter().map(|v| scales[f] * v).collect();
                problem.noise.whitened(problem.experiments[i], &all)
            })
            .collect()
    };
    problem.responses_to(fit, (channels * count, group(count)), series).ok()
}

/// The standard deviation of the model errors of each channel, estimated from the residual of a fit.
///
/// A fit absorbs a part of the errors: errors with features `Φ` and standard deviation `s` add only `s² tr L` to the expected weighted sum of
/// squares, with `L = Φᵀ (W − W J H⁻¹ Jᵀ W) Φ`. Equating this to the excess over the noise estimates `s²` (method of moments). The effective
/// degrees of freedom of the estimate are `ν = (tr L)² / tr L²` (Satterthwaite 1946), so the deviation is multiplied by the ratio of the
/// quantiles of Student's t and the normal distribution.
fn unexplained_deviations(
    responses: &Responses,
    mean_squares: &[f64],
    observations: f64,
) -> Vec<f64> {
    let count = responses.left.len() / mean_squares.len().max(1);
    let of_channel = |(left, mean_square): (&[Vec<f64>], &f64)| {
        let trace: f64 = left.iter().enumerate().map(|(k, row)| row[k]).sum();
        let square: f64 = left.iter().flatten().map(|l| l * l).sum();
        if trace <= 0.0 || square <= 0.0 {
            return 0.0;
        }
        let excess = (1.0 - 1.0 / mean_square.max(1.0)) * observations;
        (excess / trace).sqrt() * t_quantile_95(trace * trace / square) / HALF_WIDTH
    };
    responses.left.chunks(count.max(1)).zip(mean_squares).map(of_channel).collect()
}
