//! The reflected mass.
//!
//! In `F = m ẍ + f(x, ẋ, m_f, m_e)` with a free function f only that part of ẍ says something of m that
//! is no function of f's inputs. Steady sines come close to leaving none: on one ellipse of frequency ω,
//! `ẍ = −ω² x`. The regression of a partially linear model (Robinson 1988) makes this exact:
//!
//! ```text
//! e = ẍ − E[ẍ | x, ẋ, m_f, m_e],   r = F − m ẍ − f,   δ = Σ e r / Σ e²
//! ```
//!
//! The expectation is fitted by a network of f's own shape. Because e is orthogonal to what f can become,
//! errors of f enter δ in second order only (Chernozhukov et al. 2018).

use super::by_groups;
use crate::coordinates::{Coordinates, Frozen, NetworkJoint, PHYSICAL, PhysicalForm, Scaling};
use crate::evaluation::Subject;
use crate::warm_start::derivative_matching::{DerivativeMatching, Point};
use pam_core::{ForceInput, ForceModel};
use serde::Serialize;

/// What the data say of m.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MassEstimate {
    /// The model's m, kg.
    pub mass_kg: f64,
    /// What the balance of forces would change it by, kg: δ.
    pub correction_kg: f64,
    /// Standard error over recordings, kg; none for fewer than two recordings.
    pub standard_error_kg: Option<f64>,
    /// Share of the acceleration's variance that the force's inputs do not tell.
    pub unexplained_share: f64,
    /// Root mean square of the force that is left, N.
    pub residual_n: f64,
}

/// Smallest share of the acceleration that must be its own for m to count as identified: below it a
/// force that is wrong by a thousandth is as good as a change of m by a tenth.
const LEAST_SHARE: f64 = 1e-3;
/// Largest relative standard error of a mass that counts as identified.
const LARGEST_ERROR: f64 = 0.1;

impl MassEstimate {
    /// Why m is not identified, if it is not.
    #[must_use]
    pub fn doubt(&self) -> Option<String> {
        let Some(error) = self.standard_error_kg else {
            return Some("no standard error: it takes two recordings".into());
        };
        if self.unexplained_share < LEAST_SHARE || error > LARGEST_ERROR * self.mass_kg {
            return Some(format!(
                "not identified: all but {:.2} % of the acceleration is a function of the force's \
                 inputs; excite with several amplitudes and frequencies at once",
                100.0 * self.unexplained_share
            ));
        }
        (self.correction_kg.abs() > 3.0 * error).then(|| {
            format!(
                "the balance of forces alone says {:.1} kg: the trained force has taken on inertia, \
                 or the model lacks a force",
                self.mass_kg + self.correction_kg
            )
        })
    }
}

/// What recordings say of a model's m.
#[must_use]
pub fn identify_mass(
    model: &NetworkJoint,
    subjects: &[Subject],
    matching: &DerivativeMatching,
    seed: u64,
) -> MassEstimate {
    let points: Vec<Vec<Point>> = subjects.iter().map(|s| matching.points(s)).collect();
    let mass = model.physical().mass_kg;
    let scaling = Scaling::of_data(subjects);
    // The regression of the acceleration is that of a force without inertia.
    let square = points.iter().flatten().map(|p| p.acceleration * p.acceleration).sum::<f64>();
    let count = points.iter().map(Vec::len).sum::<usize>().max(1) as f64;
    let unit = scaling.force_mn / (square / count).sqrt().max(f64::MIN_POSITIVE);
    let targets = points
        .iter()
        .flatten()
        .map(|p| Point { acceleration: 0.0, force_mn: unit * p.acceleration, ..*p })
        .collect();
    let frozen = Frozen { mass: true, gas_coefficient: true, deformation: true, network: false };
    let mut template = model.clone();
    template.auxiliary_damping_kg_s = 0.0;
    let coordinates =
        Coordinates::new(template, scaling, PhysicalForm::Logarithm, frozen);
    let start = coordinates.of(model);
    debug_assert!(start.len() > PHYSICAL);
    let expected = coordinates.model(&matching.regress(&coordinates, &start, targets, seed, &|_, _| {}).at);

    let mut work = vec![0.0; model.force.work_len()];
    let mut force = |of: &NetworkJoint, p: &Point| {
        let [mass_flexor_g, mass_extensor_g, displacement_mm, velocity_mm_s] = p.input;
        let at = ForceInput { displacement_mm, velocity_mm_s, mass_flexor_g, mass_extensor_g };
        of.force.restoring_force_mn(&at, &mut work)
    };
    let (mut own_square, mut residual_square) = (0.0, 0.0);
    let groups: Vec<(f64, f64)> = points
        .iter()
        .map(|recording| {
            recording.iter().fold((0.0, 0.0), |sum, p| {
                let own = p.acceleration - force(&expected, p) / unit;
                let residual = p.force_mn - mass * p.acceleration - force(model, p);
                own_square += own * own;
                residual_square += residual * residual;
                (sum.0 + own * residual, sum.1 + own * own)
            })
        })
        .collect();
    let (correction_kg, standard_error_kg) = by_groups(&groups);
    MassEstimate {
        mass_kg: mass,
        correction_kg,
        standard_error_kg,
        unexplained_share: own_square / square.max(f64::MIN_POSITIVE),
        residual_n: 1e-3 * (residual_square / count).sqrt(),
    }
}
