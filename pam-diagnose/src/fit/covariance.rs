//! How sure fitted numbers are.

use super::hypothesis::coordinate;
use super::problem::Problem;
use super::solve::Fit;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use pam_effects::effects::ParameterInfo;
use pam_effects::simulation::Diverged;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// A value with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
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
}

impl Problem<'_> {
    /// The fitted parameters with 95 % intervals, in the order of [`Hypothesis::parameters`].
    ///
    /// The covariance is clustered by blocks of two seconds, `H⁻¹ (Σ_b g_b g_bᵀ) H⁻¹` with
    /// `g_b = J_bᵀ W r_b`, which holds whatever the correlation of the residuals inside a block (Liang and
    /// Zeger 1986), with quantiles of Student's t for the number of blocks. Scales have intervals that are
    /// symmetric in their logarithm.
    ///
    /// [`Hypothesis::parameters`]: super::Hypothesis::parameters
    ///
    /// # Errors
    /// [`Diverged`] if the fitted hypothesis cannot be simulated.
    pub fn intervals(&self, fit: &Fit<'_>) -> Result<Vec<Interval>, Diverged> {
        let joint = self.linearised(&fit.hypothesis, &fit.errors)?;
        let parameters = fit.hypothesis.parameters();
        let h = joint.hessian(0.0);
        let n = h.nrows();
        let scale: Vec<f64> = (0..n).map(|i| h[(i, i)].sqrt().recip()).collect();
        let scaled = Mat::from_fn(n, n, |i, j| h[(i, j)] * scale[i] * scale[j]);
        let blocks = joint.blocks.len() as f64;
        let errors: Vec<f64> = match scaled.llt(Side::Lower) {
            Err(_) => vec![f64::INFINITY; parameters.len()],
            Ok(factor) => (0..parameters.len())
                .map(|k| {
                    let unit = Mat::from_fn(n, 1, |i, _| if i == k { scale[k] } else { 0.0 });
                    let row = factor.solve(&unit);
                    let influence = |block: &Vec<f64>| -> f64 {
                        (0..n).map(|i| row[(i, 0)] * scale[i] * block[i]).sum()
                    };
                    let clustered: f64 = joint.blocks.iter().map(|b| influence(b).powi(2)).sum();
                    let tied: f64 =
                        (0..n).map(|i| (row[(i, 0)] * scale[i]).powi(2) * joint.ties[i]).sum();
                    (clustered * blocks / (blocks - 1.0).max(1.0) + tied).sqrt()
                })
                .collect(),
        };
        let freedom = (blocks - 1.0 - parameters.len() as f64).max(1.0);
        let quantile = StudentsT::new(0.0, 1.0, freedom).map_or(1.96, |t| t.inverse_cdf(0.975));
        Ok(parameters
            .iter()
            .zip(errors)
            .map(|((at, info), error)| {
                let value = fit.hypothesis.values[*at];
                let middle = coordinate(value, *info);
                let end = |s: f64| {
                    let e = middle + s * quantile * error;
                    if info.logarithmic { e.exp() } else { e }
                };
                Interval { value, ci95: [end(-1.0), end(1.0)] }
            })
            .collect())
    }
}
