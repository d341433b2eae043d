//! Derivative matching with a corrected mass.

use super::derivative_matching::{DerivativeMatching, Matched, Point};
use super::own_acceleration::{mass_correction_kg, own_accelerations};
use crate::coordinates::{Coordinates, Frozen};
use pam_data::Subject;

/// Share of the rate with which the regression with the corrected mass begins.
const RATE_SHARE: f64 = 0.3;
/// Share of m that one correction changes it by at most.
const LARGEST_CORRECTION: f64 = 0.5;

impl DerivativeMatching {
    /// Regresses m and the network on recordings, from the coordinates `start`; corrects m and regresses the network
    /// again if `mass_steps` asks for it.
    #[must_use]
    pub fn run(
        &self,
        coordinates: &Coordinates,
        start: &[f64],
        subjects: &[Subject],
        seed: u64,
    ) -> Matched {
        let points: Vec<Point> = subjects.iter().flat_map(|s| self.points(s)).collect();
        let joint = self.regress(coordinates, start, points.clone(), seed);
        // Numbers that are not finite are for the caller to report.
        let diverged = joint.at.iter().any(|v| !v.is_finite());
        if self.mass_steps == 0 || points.is_empty() || coordinates.frozen().mass || diverged {
            return joint;
        }
        let again = Self { steps: self.mass_steps, ..*self };
        let own = own_accelerations(&again, coordinates, &joint.at, &points, seed);
        let mut model = coordinates.model(&joint.at);
        let mut physical = model.physical();
        let most = LARGEST_CORRECTION * physical.mass_kg;
        let correction = mass_correction_kg(&own);
        if !(correction.is_finite() && most.is_finite()) {
            return joint;
        }
        physical.mass_kg += correction.clamp(-most, most);
        model.raw = physical.to_raw();
        let held = coordinates.with_frozen(Frozen { mass: true, ..coordinates.frozen() });
        // Only the mass changes: the network stays unchanged, bit for bit.
        let mut at = joint.at;
        let mass = coordinates.weights_len();
        at[mass] = coordinates.of(&model)[mass];
        Self { rate: RATE_SHARE * again.rate, ..again }.regress(&held, &at, points, seed ^ 1)
    }
}
