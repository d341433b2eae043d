//! How well the data fix the physical parameters: standard errors, and whether there is anything to have
//! an error of.
//!
//! - [`mass`]: m by what of the acceleration the force network's inputs do not tell;
//! - [`deformation`]: ν by pressures, and separately at each frequency of the excitation.
//!
//! The unit of sampling is the recording: within one, errors are anything but independent.

pub mod deformation;
pub mod mass;

pub use deformation::{DeformationEstimate, FrequencyEstimate, identify_deformation};
pub use mass::{MassEstimate, identify_mass};

use serde::Serialize;

/// Estimates of a model's physical parameters from its training recordings. C is not among them: pressures
/// show only its product with the masses, which come from the same gas law.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Identification {
    /// Of m.
    pub mass: MassEstimate,
    /// Of ν.
    pub deformation: DeformationEstimate,
}

/// An estimate of one number by least squares, `value = Σ a/Σ b` over groups, and its standard error
///
/// ```text
/// se² = n/(n − 1) · Σ_g (a_g − value · b_g)² / (Σ b)²
/// ```
///
/// that holds for errors that are correlated within groups in whatever way (Liang and Zeger 1986); none
/// for fewer than two groups.
pub(crate) fn by_groups(groups: &[(f64, f64)]) -> (f64, Option<f64>) {
    let (a, b) = groups.iter().fold((0.0, 0.0), |s, g| (s.0 + g.0, s.1 + g.1));
    if b.is_nan() || b <= 0.0 {
        return (0.0, None);
    }
    let value = a / b;
    let n = groups.len() as f64;
    let spread: f64 = groups.iter().map(|g| (g.0 - value * g.1).powi(2)).sum();
    let error = (n > 1.0).then(|| (n / (n - 1.0) * spread).sqrt() / b);
    (value, error)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of equal groups it is the standard error of the mean, by its textbook formula.
    #[test]
    fn equal_groups_give_the_standard_error_of_a_mean() {
        let values = [1.0, 2.0, 4.0, 9.0];
        let groups: Vec<(f64, f64)> = values.iter().map(|v| (3.0 * v, 3.0)).collect();
        let (value, error) = by_groups(&groups);
        let variance = values.iter().map(|v| (v - 4.0) * (v - 4.0)).sum::<f64>() / 3.0;
        assert!((value - 4.0).abs() < 1e-14);
        assert!((error.unwrap() - (variance / 4.0).sqrt()).abs() < 1e-14);
        assert_eq!(by_groups(&groups[..1]), (1.0, None));
        assert_eq!(by_groups(&[]), (0.0, None));
    }
}
