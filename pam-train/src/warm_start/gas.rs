//! The deformation coefficient from pressures alone.

use num_dual::Dual64;
use pam_core::{MuscleGeometry, Scalar};
use pam_data::Subject;
use std::ops::Range;

/// A deformation coefficient fitted to pressures. Its standard error is a matter of
/// [`identification`](crate::identification::deformation).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedDeformation {
    /// ν.
    pub deformation: f64,
    /// Root mean square of the residuals, kPa.
    pub rms_kpa: f64,
}

/// Samples of a recording.
#[derive(Debug, Clone)]
pub struct Stretch<'a> {
    /// The recording.
    pub subject: &'a Subject,
    /// The samples.
    pub range: Range<usize>,
}

/// Sums of the least-squares problem over one stretch, with errors `e` (kPa) and slopes
/// `s = ∂P/∂ν` of the predicted pressures.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DeformationSums {
    /// Σ s e.
    pub slope_error: f64,
    /// Σ s².
    pub slope_square: f64,
    /// Σ e².
    pub error_square: f64,
    /// Number of pressures.
    pub count: f64,
}

/// Fits ν so that the sealed gas `P = P(0) V(x(0))/V(x)` follows the measured pressures along the
/// measured displacements, in least squares by Gauss–Newton. C and the masses drop out: they are
/// tied to the pressures at the start.
#[must_use]
pub fn fit_deformation(
    subjects: &[Subject],
    geometry: &MuscleGeometry,
    start: f64,
) -> FittedDeformation {
    let stretches: Vec<Stretch<'_>> =
        subjects.iter().map(|s| Stretch { subject: s, range: 0..s.recording.len() }).collect();
    let (deformation, sums) = deformation_of(&stretches, geometry, start);
    let (square, count) =
        sums.iter().fold((0.0, 0.0), |t, s| (t.0 + s.error_square, t.1 + s.count));
    FittedDeformation { deformation, rms_kpa: (square / f64::max(count, 1.0)).sqrt() }
}

/// The same over stretches of recordings; returns ν and the sums of each stretch there. A stretch is
/// predicted from the first sample of its recording.
#[must_use]
pub fn deformation_of(
    stretches: &[Stretch<'_>],
    geometry: &MuscleGeometry,
    start: f64,
) -> (f64, Vec<DeformationSums>) {
    let at = |nu: f64| stretches.iter().map(|s| sums_of(s, geometry, nu)).collect::<Vec<_>>();
    let mut nu = start;
    for _ in 0..50 {
        let (error, square) =
            at(nu).iter().fold((0.0, 0.0), |t, s| (t.0 + s.slope_error, t.1 + s.slope_square));
        let next = (nu + error / f64::max(square, f64::MIN_POSITIVE)).max(0.6);
        let moved = (next - nu).abs();
        nu = next;
        if moved < 1e-12 * nu {
            break;
        }
    }
    (nu, at(nu))
}

fn sums_of(stretch: &Stretch<'_>, geometry: &MuscleGeometry, nu: f64) -> DeformationSums {
    let r = &stretch.subject.recording;
    let dual = Dual64::new(nu, 1.0);
    let volumes = |x: f64| {
        let v = geometry.volumes(Dual64::constant(x), dual);
        [v.flexor_mm3, v.extensor_mm3]
    };
    let start = volumes(r.displacement_mm[0]);
    let columns = [&r.pressure_flexor_kpa, &r.pressure_extensor_kpa];
    let mut sums = DeformationSums::default();
    for k in stretch.range.clone() {
        let now = volumes(r.displacement_mm[k]);
        for i in 0..2 {
            let predicted = start[i] / now[i] * columns[i][0];
            let error = columns[i][k] - predicted.re;
            sums.slope_error += predicted.eps * error;
            sums.slope_square += predicted.eps * predicted.eps;
            sums.error_square += error * error;
            sums.count += 1.0;
        }
    }
    sums
}
