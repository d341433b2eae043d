//! Experiments whose own nuisances were not fitted.

use crate::search::Nuisance;
use pam_numerics::ScaledCholesky;
use pam_numerics::dot;

/// The part of the whitened residual of one experiment that its nuisances would explain: the projection on their sensitivities `Z`,
/// with their priors, `r − Z (ZᵀZ + Σ⁻¹)⁻¹ Zᵀ r`.
///
/// Start, sealed masses and offsets belong to an experiment, not to a hypothesis; their effect is linear over their priors.
#[derive(Debug)]
pub(crate) struct UnseenNuisances {
    columns: Vec<Vec<Vec<f64>>>,
    factor: Option<ScaledCholesky>,
    precisions: Vec<f64>,
}

impl UnseenNuisances {
    pub(super) fn new(columns: Vec<Vec<Vec<f64>>>, priors: &[Nuisance]) -> Self {
        let entry = |i: usize, j: usize| {
            let data: f64 = columns[i].iter().zip(&columns[j]).map(|(a, b)| dot(a, b)).sum();
            data + if i == j { priors[i].deviation.powi(-2) } else { 0.0 }
        };
        let factor = ScaledCholesky::new(columns.len(), entry, 0.0);
        let precisions = priors.iter().map(|p| p.deviation.powi(-2)).collect();
        Self { columns, factor, precisions }
    }

    /// The values of the nuisances that fit the residuals best; `None` if they cannot be told.
    fn values(&self, residuals: &[Vec<f64>]) -> Option<Vec<f64>> {
        let of =
            |column: &Vec<Vec<f64>>| column.iter().zip(residuals).map(|(z, r)| dot(z, r)).sum();
        let right: Vec<f64> = self.columns.iter().map(of).collect();
        self.factor.as_ref().and_then(|f| f.solve(&right))
    }

    /// The prior cost of these values, `Σ (value / prior standard deviation)²`.
    pub(super) fn prior_cost(&self, residuals: &[Vec<f64>]) -> f64 {
        let values = self.values(residuals).unwrap_or_default();
        values.iter().zip(&self.precisions).map(|(v, p)| v * v * p).sum()
    }

    pub(super) fn cleared(&self, mut residuals: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let Some(values) = self.values(&residuals) else { return residuals };
        for (value, column) in values.iter().zip(&self.columns) {
            for (r, z) in residuals.iter_mut().zip(column) {
                r.iter_mut().zip(z).for_each(|(r, z)| *r -= value * z);
            }
        }
        residuals
    }
}
