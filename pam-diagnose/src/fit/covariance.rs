//! Confidence intervals of fitted parameters.

use super::hypothesis::coordinate;
use super::levenberg_marquardt::Fit;
use super::problem::Problem;
use crate::error::DiagnoseError;
use crate::search::Candidates;
use pam_core::parallel;
use pam_numerics::statistics::t_quantile_95;
use pam_numerics::{ScaledCholesky, dot};
use pam_vocabulary::ParameterInfo;
use serde::Serialize;

/// Half a 95 % interval of a normal variable in standard deviations.
pub(crate) const HALF_WIDTH: f64 = 1.96;

/// A value with its 95 % confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// The value.
    pub value: f64,
    /// Lower and upper end.
    pub ci95: [f64; 2],
}

impl Interval {
    /// The interval with another independent source of error, as half its own 95 % interval in the coordinate
    /// in which the parameter is fitted.
    #[must_use]
    pub fn widened(&self, half_width: f64, info: ParameterInfo) -> Self {
        let middle = coordinate(self.value, info);
        let end = |end: f64, sign: f64| {
            let own = (coordinate(end, info) - middle).abs();
            let both = middle + sign * own.hypot(half_width);
            if info.logarithmic { both.exp() } else { both }
        };
        Self { value: self.value, ci95: [end(self.ci95[0], -1.0), end(self.ci95[1], 1.0)] }
    }

    /// An interval of the same widths, in the coordinate in which the parameter is fitted, around another value.
    pub(crate) fn moved_to(&self, value: f64, info: ParameterInfo) -> Self {
        let by = coordinate(value, info) - coordinate(self.value, info);
        let moved = |end: f64| {
            let end = coordinate(end, info) + by;
            if info.logarithmic { end.exp() } else { end }
        };
        Self { value, ci95: self.ci95.map(moved) }
    }

    /// The standard deviation of a normal variable with this interval.
    pub(crate) fn deviation(&self) -> f64 {
        0.5 * (self.ci95[1] - self.ci95[0]) / HALF_WIDTH
    }

    /// Whether the interval holds a value.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.ci95[0] <= value && value <= self.ci95[1]
    }
}

/// How much each block of rows moves each parameter: `H⁻¹ g_b` with the Hessian `H` of the cost and the score `g_b` of the
/// block, in the coordinate in which the parameter is fitted. The sum over all blocks is zero at the best fit, but for
/// priors.
#[derive(Debug, Clone)]
pub(crate) struct Influences {
    /// For each fitted parameter one value for each block.
    pub(crate) values: Vec<Vec<f64>>,
    /// The place of the experiment of each block.
    pub(crate) experiments: Vec<usize>,
}

impl<C: Candidates + ?Sized> Problem<'_, C> {
    /// The influences of all blocks on all fitted parameters.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails.
    pub(crate) fn influences(&self, fit: &Fit) -> Result<Influences, DiagnoseError> {
        let equations = self.normal_equations(&fit.hypothesis, &fit.errors)?;
        let count = fit.hypothesis.parameters(self.system).len();
        let factor = equations.factor();
        let of_parameter = |k: usize| -> Vec<f64> {
            let row = inverse_row(factor.as_ref(), equations.unknowns(), k);
            let row = row.unwrap_or_else(|| vec![0.0; equations.unknowns()]);
            equations.blocks.iter().map(|b| dot(&row, b)).collect()
        };
        let values = (0..count).map(of_parameter).collect();
        Ok(Influences { values, experiments: equations.experiments.clone() })
    }

    /// By how much each fitted parameter moves, in the coordinate in which it is fitted, when each of some series is added to the
    /// residuals: `H⁻¹ Jᵀ W s`. `series` gives those of an experiment as whitened rows of all channels.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the fitted hypothesis cannot be simulated.
    pub(crate) fn moved_by(
        &self,
        fit: &Fit,
        count: usize,
        series: impl Fn(usize) -> Vec<Vec<Vec<f64>>> + Sync,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let equations = self.normal_equations(&fit.hypothesis, &fit.errors)?;
        let weights = self.weights(&fit.errors);
        let parameters = fit.hypothesis.parameters(self.system).len();
        let common = parameters + self.system.shared().len();
        let factor = equations.factor();
        let rows: Vec<Vec<f64>> = (0..parameters)
            .map(|k| {
                let row = inverse_row(factor.as_ref(), equations.unknowns(), k);
                row.unwrap_or_else(|| vec![0.0; equations.unknowns()])
            })
            .collect();
        let each: Result<Vec<Vec<Vec<f64>>>, DiagnoseError> = parallel::map(self.len(), |i| {
            let s = self.whitened_sensitivities(&fit.hypothesis, i)?;
            let local = common + self.system.local().len() * i;
            let place = |k: usize| if k < common { k } else { local + (k - common) };
            let mut moved = vec![vec![0.0; count]; parameters];
            for (j, rows_of_series) in series(i).iter().enumerate() {
                for (k, column) in s.columns.iter().enumerate() {
                    let channels = column.iter().zip(rows_of_series).zip(&weights);
                    let product: f64 = channels.map(|((c, r), w)| w * dot_of(c, r)).sum();
                    for (moved, row) in moved.iter_mut().zip(&rows) {
                        moved[j] += row[place(k)] * product;
                    }
                }
            }
            Ok(moved)
        })
        .into_iter()
        .collect();
        let mut sum = vec![vec![0.0; count]; parameters];
        for own in each? {
            for (sum, own) in sum.iter_mut().flatten().zip(own.iter().flatten()) {
                *sum += own;
            }
        }
        Ok(sum)
    }

    /// The fitted parameters with 95 % intervals, member by member.
    ///
    /// The covariance is clustered by blocks of rows, `H⁻¹ (Σ_b g_b g_bᵀ) H⁻¹` with `g_b = J_bᵀ W r_b`, which holds
    /// for any correlation of the residuals inside a block (Liang and Zeger 1986), with quantiles of Student's t for
    /// the number of blocks. Scales have intervals that are symmetric in their logarithm. An error that comes from a
    /// nuisance with limits ends where the nuisance is at its limit: the sides of such an interval may differ.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the fitted hypothesis cannot be simulated.
    pub fn intervals(&self, fit: &Fit) -> Result<Vec<Interval>, DiagnoseError> {
        let equations = self.normal_equations(&fit.hypothesis, &fit.errors)?;
        let parameters = fit.hypothesis.parameters(self.system);
        let blocks = equations.blocks.len() as f64;
        let factor = equations.factor();
        let row = |k: usize| inverse_row(factor.as_ref(), equations.unknowns(), k);
        let covariance = |a: &[f64], b: &[f64]| -> f64 {
            let clustered: f64 = equations.blocks.iter().map(|g| dot(a, g) * dot(b, g)).sum();
            let priors = a.iter().zip(b).zip(&equations.precisions);
            clustered * blocks / (blocks - 1.0).max(1.0)
                + priors.map(|((a, b), p)| a * b * p).sum::<f64>()
        };
        let quantile = t_quantile_95((blocks - 1.0 - parameters.len() as f64).max(1.0));
        let shared = self.system.shared().iter().zip(&fit.hypothesis.shared).enumerate();
        let limited: Vec<Limited> = shared
            .filter(|(_, (n, _))| !n.is_unlimited())
            .filter_map(|(k, (n, value))| {
                let row = row(parameters.len() + k)?;
                let deviation = covariance(&row, &row).sqrt();
                let room = n.limits.map(|limit| (limit - value).abs() / deviation);
                (deviation > 0.0).then_some(Limited { row, deviation, room })
            })
            .collect();
        let half_widths = |k: usize| -> Option<[f64; 2]> {
            let row = row(k)?;
            let variance = covariance(&row, &row);
            let by_nuisance = limited.iter().map(|n| (covariance(&row, &n.row) / n.deviation, n));
            let most = by_nuisance.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
            let Some((moved, nuisance)) = most else {
                return Some([quantile * variance.sqrt(); 2]);
            };
            let rest = quantile * (variance - moved * moved).max(0.0).sqrt();
            let mut room = nuisance.room;
            if moved < 0.0 {
                room.reverse();
            }
            Some(room.map(|room| rest.hypot(moved * room.min(quantile))))
        };
        Ok(parameters
            .iter()
            .enumerate()
            .map(|(k, p)| {
                let [below, above] = half_widths(k).unwrap_or([f64::INFINITY; 2]);
                let value = fit.hypothesis.members[p.member].values[p.value];
                let middle = coordinate(value, p.info);
                let ends = [middle - below, middle + above];
                Interval { value, ci95: if p.info.logarithmic { ends.map(f64::exp) } else { ends } }
            })
            .collect())
    }
}

/// Row `k` of the inverse of a factored Hessian; `None` if it is singular.
fn inverse_row(factor: Option<&ScaledCholesky>, unknowns: usize, k: usize) -> Option<Vec<f64>> {
    let mut unit = vec![0.0; unknowns];
    unit[k] = 1.0;
    factor?.solve(&unit)
}

/// The error of a nuisance with limits.
struct Limited {
    /// Row of the inverse Hessian.
    row: Vec<f64>,
    /// Standard deviation.
    deviation: f64,
    /// Distances to the lower and the upper limit, in standard deviations.
    room: [f64; 2],
}

/// The inner product of two channels, of which an empty one is zero.
fn dot_of(a: &[f64], b: &[f64]) -> f64 {
    if a.is_empty() || b.is_empty() { 0.0 } else { dot(a, b) }
}
