//! What the model's own errors add to the intervals of named causes.

use crate::fit::{Fit, HALF_WIDTH, Problem};
use crate::residual::flexible::FeatureRows;
use crate::search::Candidates;

/// By how much errors of the model, each by one standard deviation, move the fitted parameters.
pub(crate) struct ModelErrors {
    /// For each fitted parameter, in the coordinate in which it is fitted, one value for each error.
    moved: Vec<Vec<f64>>,
}

impl ModelErrors {
    /// Half the 95 % interval that they give a parameter.
    pub(crate) fn half_width(&self, parameter: usize) -> f64 {
        HALF_WIDTH * self.covariance(parameter, parameter).sqrt()
    }

    /// The covariance that they give two parameters.
    pub(crate) fn covariance(&self, i: usize, j: usize) -> f64 {
        self.moved[i].iter().zip(&self.moved[j]).map(|(a, b)| a * b).sum()
    }
}

/// The changes of the fitted parameters by the model's own errors; none if the simulation of the fit fails.
///
/// Errors of a model repeat with the motion, in all recordings alike. So no scatter of residuals between blocks or recordings
/// shows what they do to a parameter that they look like, and more data make an interval shorter and not right (Brynjarsdóttir and
/// O'Hagan 2014). The error of each channel is a sum of features of the motion with independent coefficients
/// of mean zero, scaled so that each of them has the same part of the [discrepancy](crate::noise::Noise::discrepancy) that the
/// model is known to have; each coefficient moves the parameters by `H⁻¹ Jᵀ W φ`.
pub(crate) fn model_errors<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    fit: &Fit,
) -> ModelErrors {
    let parameters = fit.hypothesis.parameters(problem.system).len();
    ModelErrors { moved: moved(problem, fit).unwrap_or_else(|| vec![Vec::new(); parameters]) }
}

fn moved<C: Candidates + ?Sized>(problem: &Problem<'_, C>, fit: &Fit) -> Option<Vec<Vec<f64>>> {
    let rows = FeatureRows::gather(problem, &fit.hypothesis)?;
    let channels = problem.noise.channels();
    let (n, count) = (rows.len().max(1) as f64, rows.features.len());
    // Standard deviation of the coefficient of each feature in each channel.
    let size = |f: &Vec<f64>| (f.iter().map(|v| v * v).sum::<f64>() / n).sqrt();
    let sizes: Vec<f64> = rows.features.iter().map(size).collect();
    let deviation = |c: usize, f: usize| {
        let share = problem.noise.discrepancy(c) / (count as f64).sqrt();
        if sizes[f] > 0.0 { share / sizes[f] } else { 0.0 }
    };
    let series = |i: usize| -> Vec<Vec<Vec<f64>>> {
        let range = rows.experiments[i].clone();
        (0..channels * count)
            .map(|k| {
                let (c, f) = (k / count, k % count);
                let mut all = vec![Vec::new(); channels];
                all[c] =
                    rows.features[f][range.clone()].iter().map(|v| deviation(c, f) * v).collect();
                problem.noise.whitened(problem.experiments[i], &all)
            })
            .collect()
    };
    problem.moved_by(fit, channels * count, series).ok()
}
