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

/// The linear response of a fit to perturbations of its residuals.
#[derive(Debug, Clone)]
pub(crate) struct Responses {
    /// The shift of each fitted parameter by each perturbation `s`, in the coordinate in which the parameter is fitted: `H⁻¹ Jᵀ W s`.
    pub(crate) moved: Vec<Vec<f64>>,
    /// For each perturbation, the weighted inner products of the part that the fit does not absorb with the perturbations `S` of its
    /// group: `Sᵀ (W − W J H⁻¹ Jᵀ W) s`.
    pub(crate) left: Vec<Vec<f64>>,
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

    /// The linear response of a fit to `count` perturbations of its residuals. `series` returns those of an experiment as whitened rows of
    /// all channels; consecutive perturbations form groups of size `group`.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the fitted hypothesis cannot be simulated.
    pub(crate) fn responses_to(
        &self,
        fit: &Fit,
        (count, group): (usize, usize),
        series: impl Fn(usize) -> Vec<Vec<Vec<f64>>> + Sync,
    ) -> Result<Responses, DiagnoseError> {
        let equations = self.normal_equations(&fit.hypothesis, &fit.errors)?;
        let weights = self.weights(&fit.errors);
        let parameters = fit.hypothesis.parameters(self.system).len();
        let common = parameters + self.system.shared().len();
        let inner = |a: &[Vec<f64>], b: &[Vec<f64>]| -> f64 {
            let channels = a.iter().zip(b).zip(&weights);
            channels.map(|((a, b), w)| w * dot_of(a, b)).sum()
        };
        let group_of = |k: usize| k / group * group..(k / group * group + group).min(count);
        // `Jᵀ W s` and `Sᵀ W s` of each perturbation.
        type Products = Vec<(Vec<f64>, Vec<f64>)>;
        let each: Result<Vec<Products>, DiagnoseError> = parallel::map(self.len(), |i| {
            let s = self.whitened_sensitivities(&fit.hypothesis, i)?;
            let all = series(i);
            let products = |k: usize| {
                let columns = s.columns.iter().map(|column| inner(column, &all[k]));
                (columns.collect(), group_of(k).map(|j| inner(&all[j], &all[k])).collect())
            };
            Ok((0..count).map(products).collect())
        })
        .into_iter()
        .collect();
        let mut products = vec![vec![0.0; equations.unknowns()]; count];
        let mut left: Vec<Vec<f64>> = (0..count).map(|k| vec![0.0; group_of(k).len()]).collect();
        for (i, own) in each?.into_iter().enumerate() {
            let local = common + self.system.local().len() * i;
            for (j, (columns, pairs)) in own.into_iter().enumerate() {
                left[j].iter_mut().zip(pairs).for_each(|(left, pair)| *left += pair);
                for (k, product) in columns.into_iter().enumerate() {
                    products[j][if k < common { k } else { local + (k - common) }] += product;
                }
            }
        }
        let factor = equations.factor();
        let moved = |product: &Vec<f64>| {
            let moved = factor.as_ref().and_then(|f| f.solve(product));
            moved.unwrap_or_else(|| vec![0.0; product.len()])
        };
        let mut moved: Vec<Vec<f64>> = products.iter().map(moved).collect();
        for (k, left) in left.iter_mut().enumerate() {
            for (left, j) in left.iter_mut().zip(group_of(k)) {
                *left -= dot(&moved[k], &products[j]);
            }
        }
        moved.iter_mut().for_each(|m| m.truncate(parameters));
        Ok(Responses { moved, left })
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
            let rest = (variance - moved * moved).max(0.0).sqrt();
            let mut room = nuisance.room;
            if moved < 0.0 {
                room.reverse();
            }
            // The extreme value of the parameter in the joint ellipse of radius `quantile`, cut where the nuisance is at its limit.
            let farthest = quantile * moved.abs() / variance.sqrt().max(f64::MIN_POSITIVE);
            Some(room.map(|room| {
                let by = farthest.min(room);
                moved.abs() * by + rest * (quantile * quantile - by * by).sqrt()
            }))
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
