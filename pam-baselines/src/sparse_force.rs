//! A sparse polynomial force, in the manner of SINDy.
//!
//! ```text
//! F − m ẍ = Σ_j c_j θ_j(x, ẋ, m_f, m_e)
//! ```
//!
//! with θ all monomials up to some degree of the scaled arguments, and m among the unknowns. Sequentially
//! thresholded least squares (Brunton, Proctor and Kutz 2016): fit, drop the terms whose force is small,
//! fit the rest again, until nothing changes.

use crate::error::BaselineError;
use crate::joint::{JointBaseline, JointForce, gas_of, masses_of};
use crate::method::{FittedModel, Method, Structure, TrainingSet, go_on, is_positive};
use crate::points::motion_points;
use num_dual::Dual64;
use pam_core::{ForceInput, ForceModel, Scalar};
use pam_data::formats::npz::Array;
use pam_numerics::ScaledCholesky;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Distance of the points that are regressed on, s.
const SPACING_S: f64 = 0.01;
/// Ridge relative to the mean square of each column: monomials are nearly dependent.
const RIDGE: f64 = 1e-9;

/// How the force is found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SparseForce {
    /// Highest degree of a monomial.
    pub degree: u8,
    /// Terms whose root mean square force over the training points is below this are dropped, N.
    pub threshold_n: f64,
}

impl Default for SparseForce {
    fn default() -> Self {
        Self { degree: 3, threshold_n: 0.5 }
    }
}

/// A polynomial force with few terms.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial<S> {
    /// Exponents of `(x, ẋ, m_f, m_e)`, scaled.
    pub exponents: Vec<[u8; 4]>,
    /// Their coefficients, mN.
    pub coefficients: Vec<S>,
    /// Scales by which the arguments are divided (mm, mm/s, g, g).
    pub scales: [f64; 4],
    /// Centres that are taken from the arguments first.
    pub centres: [f64; 4],
}

impl<S: Scalar> ForceModel<S> for Polynomial<S> {
    fn restoring_force_mn(&self, at: &ForceInput<S>, _work: &mut [S]) -> S {
        let arguments =
            [at.displacement_mm, at.velocity_mm_s, at.mass_flexor_g, at.mass_extensor_g];
        let scaled: [S; 4] = std::array::from_fn(|i| {
            (arguments[i] - S::constant(self.centres[i])).scaled(1.0 / self.scales[i])
        });
        let mut force = S::zero();
        for (exponents, c) in self.exponents.iter().zip(&self.coefficients) {
            let mut term = *c;
            for (s, e) in scaled.iter().zip(exponents) {
                for _ in 0..*e {
                    term *= *s;
                }
            }
            force += term;
        }
        force
    }
}

impl JointForce for Polynomial<f64> {
    type Dual = Polynomial<Dual64>;

    fn dual(&self) -> Self::Dual {
        Polynomial {
            exponents: self.exponents.clone(),
            coefficients: self.coefficients.iter().map(|c| Dual64::constant(*c)).collect(),
            scales: self.scales,
            centres: self.centres,
        }
    }

    fn parameter_count(&self) -> usize {
        self.coefficients.len()
    }

    fn structure(&self) -> Structure {
        Structure::Dictionary
    }

    fn details(&self) -> Value {
        let terms: BTreeMap<String, f64> =
            self.exponents.iter().map(term_name).zip(self.coefficients.iter().copied()).collect();
        json!({
            "terms_mn": terms,
            "centres_mm_mm_s_g_g": self.centres,
            "scales_mm_mm_s_g_g": self.scales,
        })
    }

    fn arrays(&self) -> BTreeMap<String, Array> {
        let exponents = self.exponents.iter().flatten().map(|e| f64::from(*e)).collect();
        let shape = vec![self.exponents.len() as u64, 4];
        BTreeMap::from([
            ("exponents".into(), Array { shape, values: exponents }),
            ("coefficients_mn".into(), Array::vector(self.coefficients.clone())),
            ("scales".into(), Array::vector(self.scales.to_vec())),
            ("centres".into(), Array::vector(self.centres.to_vec())),
        ])
    }
}

/// A monomial in words, for example `x² m_f`.
fn term_name(exponents: &[u8; 4]) -> String {
    let factors: Vec<String> = ["x", "v", "m_f", "m_e"]
        .iter()
        .zip(exponents)
        .filter(|(_, e)| **e > 0)
        .map(|(name, e)| if *e == 1 { (*name).to_owned() } else { format!("{name}^{e}") })
        .collect();
    if factors.is_empty() { "1".into() } else { factors.join(" ") }
}

/// All exponents of four arguments up to a degree.
fn monomials(degree: u8) -> Vec<[u8; 4]> {
    let mut all = Vec::new();
    for a in 0..=degree {
        for b in 0..=degree - a {
            for c in 0..=degree - a - b {
                for d in 0..=degree - a - b - c {
                    all.push([a, b, c, d]);
                }
            }
        }
    }
    all
}

impl Method for SparseForce {
    fn title(&self) -> String {
        "Sparse force (SINDy)".into()
    }

    fn check(&self) -> Result<(), String> {
        if !(1..=5).contains(&self.degree) {
            return Err(format!("degree = {} must be from 1 to 5", self.degree));
        }
        if !(self.threshold_n.is_finite() && self.threshold_n >= 0.0) {
            return Err(format!("threshold_n = {} must not be negative", self.threshold_n));
        }
        Ok(())
    }

    fn fit(
        &self,
        training: &TrainingSet<'_>,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Box<dyn FittedModel>, BaselineError> {
        let dependent = || {
            BaselineError::unfit(
                "Sparse force",
                "the training recordings do not distinguish its terms; take more or other recordings, \
                 or a lower degree",
            )
        };
        let mut physical = gas_of(training.subjects);
        let mut rows: Vec<([f64; 4], f64, f64)> = Vec::new();
        for s in training.subjects {
            let masses = masses_of(&s.recording, &physical);
            rows.extend(motion_points(&s.recording, SPACING_S).iter().map(|p| {
                let at = [p.displacement_mm, p.velocity_mm_s, masses.flexor_g, masses.extensor_g];
                (at, p.acceleration_mm_s2, p.force_mn)
            }));
        }
        let share = 1.0 / rows.len().max(1) as f64;
        let mean = |i: usize| share * rows.iter().map(|r| r.0[i]).sum::<f64>();
        // Displacement and velocity keep their zero, which means something.
        let centres = [0.0, 0.0, mean(2), mean(3)];
        let scales: [f64; 4] = std::array::from_fn(|i| {
            let square: f64 = rows.iter().map(|r| (r.0[i] - centres[i]).powi(2)).sum();
            let scale = (share * square).sqrt();
            if scale > 0.0 { scale } else { 1.0 }
        });
        let exponents = monomials(self.degree);
        // Column 0 is the acceleration, whose coefficient is m.
        let n = exponents.len() + 1;
        let mut gram = vec![0.0; n * n];
        let mut right = vec![0.0; n];
        let mut row = vec![0.0; n];
        for (at, acceleration, force) in &rows {
            let scaled: [f64; 4] = std::array::from_fn(|i| (at[i] - centres[i]) / scales[i]);
            row[0] = *acceleration;
            for (to, e) in row[1..].iter_mut().zip(&exponents) {
                *to = (0..4).map(|i| scaled[i].powi(i32::from(e[i]))).product();
            }
            for i in 0..n {
                for (g, r) in gram[i * n..=i * n + i].iter_mut().zip(&row) {
                    *g += row[i] * r;
                }
                right[i] += row[i] * force;
            }
        }
        let mut kept: Vec<usize> = (0..n).collect();
        let solve = |kept: &[usize]| -> Option<Vec<f64>> {
            let at = |i: usize, j: usize| {
                let (a, b) = (kept[i].max(kept[j]), kept[i].min(kept[j]));
                gram[a * n + b]
            };
            let right: Vec<f64> = kept.iter().map(|&i| right[i]).collect();
            ScaledCholesky::new(kept.len(), at, RIDGE)?.solve(&right)
        };
        // Constant columns of one recording alone are no unknowns.
        kept.retain(|i| gram[i * n + i] > 0.0);
        let mut found = solve(&kept).ok_or_else(dependent)?;
        let threshold_mn = 1e3 * self.threshold_n;
        for round in 0..n {
            go_on(progress, round as f64 / n as f64)?;
            let strength = |k: usize| {
                let i = kept[k];
                found[k].abs() * (share * gram[i * n + i]).sqrt()
            };
            let strong: Vec<usize> = (0..kept.len())
                .filter(|&k| kept[k] == 0 || strength(k) >= threshold_mn)
                .map(|k| kept[k])
                .collect();
            if strong.len() == kept.len() {
                break;
            }
            kept = strong;
            found = solve(&kept).ok_or_else(dependent)?;
        }
        if kept.first() != Some(&0) || !is_positive(found[0]) {
            return Err(dependent());
        }
        physical.mass_kg = found[0];
        let force = Polynomial {
            exponents: kept[1..].iter().map(|k| exponents[k - 1]).collect(),
            coefficients: found[1..].to_vec(),
            scales,
            centres,
        };
        Ok(Box::new(JointBaseline::new(physical, force)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn monomials_are_counted_and_named() {
        // (n + d choose d) for four arguments.
        assert_eq!(monomials(3).len(), 35);
        assert_eq!(monomials(2).len(), 15);
        assert_eq!(term_name(&[2, 0, 1, 0]), "x^2 m_f");
        assert_eq!(term_name(&[0; 4]), "1");
    }
}
