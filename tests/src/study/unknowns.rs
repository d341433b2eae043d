//! Quantities that a laboratory knows only within a tolerance, and vectors less what they explain.
//!
//! A residual that a change within the tolerances leaves as well is no evidence of a fault, whoever reads it. With the change `d_j` of
//! the residual by one standard deviation of each quantity, what is left of a residual `r` is
//!
//! `min_a |r − Σ_j a_j d_j|² + |a|²`
//!
//! which is the square of the residual by the covariance `1 + Σ_j d_j d_jᵀ`. Each vector has one more entry for every quantity, which is
//! 1 in `d_j`, so that the minimum is a projection.

/// Standard deviations of the quantities, as the diagnosis states them in its settings.
///
/// Moving mass and deformation coefficient, relative.
pub(super) const MODEL: f64 = 2e-3;
/// Sealed masses, relative: the temperature of the air to 0.6 K.
pub(super) const SEALED_MASS: f64 = 2e-3;
/// Zero of a pressure sensor, kPa.
pub(super) const OFFSET_KPA: f64 = 0.5;
/// Time of the recorded force within its sample, samples.
pub(super) const LEAD_SAMPLES: f64 = 0.3;

/// Share of a direction that must be left of it for it to be another one.
const COLLINEAR: f64 = 1e-6;

/// An orthonormal basis of what does not count.
#[derive(Debug, Clone, Default)]
pub struct Basis(Vec<Vec<f64>>);

impl Basis {
    /// The basis of the changes by one standard deviation of each unknown quantity.
    #[must_use]
    pub fn of_unknowns(changes: Vec<Vec<f64>>) -> Self {
        let mut basis = Self::default();
        let count = changes.len();
        for (k, mut change) in changes.into_iter().enumerate() {
            change.extend((0..count).map(|j| if j == k { 1.0 } else { 0.0 }));
            basis.add(change);
        }
        basis
    }

    /// Adds a direction that may have any size; entries that it lacks are zero.
    pub fn add(&mut self, direction: Vec<f64>) {
        let before = norm(&direction);
        let mut direction = self.left(direction);
        let size = norm(&direction);
        if size > COLLINEAR * before {
            direction.iter_mut().for_each(|v| *v /= size);
            self.0.push(direction);
        }
    }

    /// What is left of a vector.
    #[must_use]
    pub fn left(&self, mut vector: Vec<f64>) -> Vec<f64> {
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
