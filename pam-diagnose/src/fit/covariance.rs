//! Confidence intervals of fitted parameters.

use super::hypothesis::coordinate;
use super::levenberg_marquardt::Fit;
use super::problem::Problem;
use crate::error::DiagnoseError;
use crate::search::Candidates;
use pam_effects::effects::ParameterInfo;
use pam_numerics::statistics::t_quantile_95;
use serde::Serialize;

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

    /// Whether the interval holds a value.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.ci95[0] <= value && value <= self.ci95[1]
    }
}

impl<C: Candidates + ?Sized> Problem<'_, C> {
    /// The fitted parameters with 95 % intervals, member by member.
    ///
    /// The covariance is clustered by blocks of rows, `H⁻¹ (Σ_b g_b g_bᵀ) H⁻¹` with `g_b = J_bᵀ W r_b`, which holds
    /// for any correlation of the residuals inside a block (Liang and Zeger 1986), with quantiles of Student's t for
    /// the number of blocks. Scales have intervals that are symmetric in their logarithm.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the fitted hypothesis cannot be simulated.
    pub fn intervals(&self, fit: &Fit) -> Result<Vec<Interval>, DiagnoseError> {
        let equations = self.normal_equations(&fit.hypothesis, &fit.errors)?;
        let parameters = fit.hypothesis.parameters(self.system);
        let n = equations.unknowns();
        let blocks = equations.blocks.len() as f64;
        let factor = equations.factor();
        let error = |k: usize| -> Option<f64> {
            let mut unit = vec![0.0; n];
            unit[k] = 1.0;
            let row = factor.as_ref()?.solve(&unit)?;
            let influence =
                |block: &Vec<f64>| -> f64 { row.iter().zip(block).map(|(r, b)| r * b).sum() };
            let clustered: f64 = equations.blocks.iter().map(|b| influence(b).powi(2)).sum();
            let prior: f64 = row.iter().zip(&equations.precisions).map(|(r, p)| r * r * p).sum();
            Some((clustered * blocks / (blocks - 1.0).max(1.0) + prior).sqrt())
        };
        let quantile = t_quantile_95((blocks - 1.0 - parameters.len() as f64).max(1.0));
        Ok(parameters
            .iter()
            .enumerate()
            .map(|(k, p)| {
                let error = error(k).unwrap_or(f64::INFINITY);
                let value = fit.hypothesis.members[p.member].values[p.value];
                let middle = coordinate(value, p.info);
                let end = |sign: f64| {
                    let end = middle + sign * quantile * error;
                    if p.info.logarithmic { end.exp() } else { end }
                };
                Interval { value, ci95: [end(-1.0), end(1.0)] }
            })
            .collect())
    }
}
