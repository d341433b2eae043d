//! Nuisance parameters: quantities that a laboratory knows only within a tolerance.
//!
//! A residual that nuisance parameters within their tolerances explain is no evidence of a fault. Let `d_j` be the change of the residual
//! by one standard deviation of nuisance parameter `j`. The squared norm of the part of a residual `r` that they do not explain is
//!
//! `min_a |r − Σ_j a_j d_j|² + |a|² = rᵀ (I + Σ_j d_j d_jᵀ)⁻¹ r`
//!
//! It is computed as a projection: every vector is augmented by one entry for each parameter, which is 1 in `d_j`.

// Prior standard deviations, those of the settings of the diagnosis.

/// Moving mass and deformation coefficient, relative.
pub(super) const MODEL: f64 = 2e-3;
/// Sealed masses, relative: the temperature of the air to 0.6 K.
pub(super) const SEALED_MASS: f64 = 2e-3;
/// Zero of a pressure sensor, kPa.
pub(super) const OFFSET_KPA: f64 = 0.5;
/// Time of the recorded force within its sample, samples.
pub(super) const LEAD_SAMPLES: f64 = 0.3;

/// Smallest relative norm of the orthogonal component of a direction that extends the basis.
const COLLINEAR: f64 = 1e-6;

/// An orthonormal basis of the changes that do not count as a fault.
#[derive(Debug, Clone, Default)]
pub struct Basis(Vec<Vec<f64>>);

impl Basis {
    /// The basis of the changes by one standard deviation of each nuisance parameter.
    #[must_use]
    pub fn of_nuisances(changes: Vec<Vec<f64>>) -> Self {
        let mut basis = Self::default();
        let count = changes.len();
        for (k, mut change) in changes.into_iter().enumerate() {
            change.extend((0..count).map(|j| if j == k { 1.0 } else { 0.0 }));
            basis.add(change);
        }
        basis
    }

    /// Adds a direction with a free amplitude; missing entries are zero.
    pub fn add(&mut self, direction: Vec<f64>) {
        let before = norm(&direction);
        let mut direction = self.orthogonal(direction);
        let size = norm(&direction);
        if size > COLLINEAR * before {
            direction.iter_mut().for_each(|v| *v /= size);
            self.0.push(direction);
        }
    }

    /// The component of a vector that is orthogonal to the basis; missing entries are zero.
    #[must_use]
    pub fn orthogonal(&self, mut vector: Vec<f64>) -> Vec<f64> {
        let whole = self.0.first().map_or(0, Vec::len).max(vector.len());
        vector.resize(whole, 0.0);
        for unit in &self.0 {
            let along: f64 = vector.iter().zip(unit).map(|(a, b)| a * b).sum();
            vector.iter_mut().zip(unit).for_each(|(v, u)| *v -= along * u);
        }
        vector
    }
}

/// The Euclidean norm.
#[must_use]
pub fn norm(v: &[f64]) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}
