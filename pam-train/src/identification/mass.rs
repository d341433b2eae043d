//! The reflected mass, by what of the acceleration the force's inputs do not tell; the method is that of
//! [`own_acceleration`](crate::warm_start::own_acceleration).

use super::by_groups;
use crate::coordinates::{Coordinates, Frozen, PhysicalForm, Scaling};
use crate::warm_start::derivative_matching::{DerivativeMatching, Point};
use crate::warm_start::own_acceleration::own_accelerations;
use pam_data::Subject;
use pam_trajectory::engine::NetworkJoint;
use serde::Serialize;

/// An estimate of m.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MassEstimate {
    /// The model's m, kg.
    pub mass_kg: f64,
    /// Correction by the balance of forces, kg: δ.
    pub correction_kg: f64,
    /// Standard error over recordings, over twelfths of a single one, kg. It grows to |δ| where the balance of forces
    /// contradicts m.
    pub standard_error_kg: Option<f64>,
    /// Standard error of δ alone, kg.
    pub scatter_kg: Option<f64>,
    /// Share of the acceleration's variance that the force's inputs do not tell.
    pub unexplained_share: f64,
    /// Root mean square of the force that is left, N.
    pub residual_n: f64,
}

/// Smallest share of the acceleration that must be its own for m to count as identified: below it a
/// force that is wrong by a thousandth is as good as a change of m by a tenth.
const LEAST_SHARE: f64 = 1e-3;
/// Relative correction that is worth telling, if it is significant.
const LEAST_CONTRADICTION: f64 = 0.01;
/// Standard errors beyond which a correction is no chance.
const SIGNIFICANCE: f64 = 3.0;
/// Parts of a single recording over which its standard error is taken.
const PARTS: usize = 12;
/// Largest relative standard error of a mass that counts as identified.
const LARGEST_ERROR: f64 = 0.1;

impl MassEstimate {
    /// m, if the recordings determine it: its relative error is below a tenth, the balance of forces does not contradict
    /// it by more, and a share of the acceleration is its own.
    #[must_use]
    pub fn determined_kg(&self) -> Option<f64> {
        let error = self.standard_error_kg?;
        let sure = error <= LARGEST_ERROR * self.mass_kg && self.unexplained_share >= LEAST_SHARE;
        sure.then_some(self.mass_kg)
    }

    /// Whether the balance of forces alone gives another m.
    fn contradicts(&self) -> bool {
        let error = self.scatter_kg.unwrap_or(f64::INFINITY);
        let correction = self.correction_kg.abs();
        correction > SIGNIFICANCE * error && correction > LEAST_CONTRADICTION * self.mass_kg
    }

    /// Why m is not identified, if it is not.
    #[must_use]
    pub fn doubt(&self) -> Option<String> {
        let Some(error) = self.standard_error_kg else {
            return Some("no standard error: the recordings are too short".into());
        };
        let unsure = error > LARGEST_ERROR * self.mass_kg && !self.contradicts();
        if self.unexplained_share < LEAST_SHARE || unsure {
            return Some(format!(
                "not identified: all but {:.2} % of the acceleration is a function of the force's \
                 inputs; excite with several amplitudes and frequencies at once",
                100.0 * self.unexplained_share
            ));
        }
        self.contradicts().then(|| {
            format!(
                "the balance of forces alone says {:.1} kg: the trained force has taken on inertia, \
                 or the model lacks a force",
                self.mass_kg + self.correction_kg
            )
        })
    }
}

/// Estimates a model's m from recordings.
#[must_use]
pub fn identify_mass(
    model: &NetworkJoint,
    subjects: &[Subject],
    matching: &DerivativeMatching,
    seed: u64,
) -> MassEstimate {
    let mut recordings: Vec<Vec<Point>> = subjects.iter().map(|s| matching.points(s)).collect();
    if let [only] = &recordings[..] {
        let part = only.len().div_ceil(PARTS).max(1);
        recordings = only.chunks(part).map(<[Point]>::to_vec).collect();
    }
    let points = recordings.concat();
    let scaling = Scaling::of_data(subjects);
    let coordinates =
        Coordinates::new(model.clone(), scaling, PhysicalForm::Logarithm, Frozen::default());
    let at = coordinates.of(model);
    let own = own_accelerations(matching, &coordinates, &at, &points, seed);

    let mut rest = &own[..];
    let groups: Vec<(f64, f64)> = recordings
        .iter()
        .map(|r| {
            let (these, after) = rest.split_at(r.len());
            rest = after;
            these.iter().fold((0.0, 0.0), |s, o| {
                (s.0 + o.acceleration * o.residual_mn, s.1 + o.acceleration * o.acceleration)
            })
        })
        .collect();
    let (correction_kg, scatter_kg) = by_groups(&groups);
    let mean = |sum: f64| sum / points.len().max(1) as f64;
    let own_square: f64 = own.iter().map(|o| o.acceleration * o.acceleration).sum();
    let square: f64 = points.iter().map(|p| p.acceleration * p.acceleration).sum();
    let left: f64 = own.iter().map(|o| o.residual_mn * o.residual_mn).sum();
    let mut estimate = MassEstimate {
        mass_kg: model.physical().mass_kg,
        correction_kg,
        standard_error_kg: scatter_kg,
        scatter_kg,
        unexplained_share: own_square / square.max(f64::MIN_POSITIVE),
        residual_n: 1e-3 * mean(left).sqrt(),
    };
    if estimate.contradicts() {
        estimate.standard_error_kg = scatter_kg.map(|e| e.hypot(correction_kg));
    }
    estimate
}
