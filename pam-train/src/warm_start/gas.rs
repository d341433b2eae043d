//! The deformation coefficient from pressures alone.

use crate::evaluation::Subject;
use num_dual::Dual64;
use pam_core::{MuscleGeometry, Scalar};

/// A deformation coefficient fitted to pressures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedDeformation {
    /// ν.
    pub deformation: f64,
    /// What its least-squares problem gives as its standard error, with the residuals taken as
    /// independent from one half cycle of 1 Hz to the next.
    pub standard_error: f64,
    /// Root mean square of the residuals, kPa.
    pub rms_kpa: f64,
}

/// Correlated stretch of a residual, s.
const CORRELATION_S: f64 = 0.5;

/// Fits ν so that the sealed gas `P = P(0) V(x(0))/V(x)` follows the measured pressures along the
/// measured displacements, in least squares by Gauss and Newton. C and the masses drop out: they are
/// tied to the pressures at the start.
#[must_use]
pub fn fit_deformation(
    subjects: &[Subject],
    geometry: &MuscleGeometry,
    start: f64,
) -> FittedDeformation {
    let mut nu = start;
    let mut sums = Sums::default();
    for _ in 0..50 {
        sums = Sums::default();
        for s in subjects {
            add(&mut sums, s, geometry, nu);
        }
        let step = sums.slope_error / sums.slope_square.max(f64::MIN_POSITIVE);
        let next = (nu + step).max(0.6);
        let moved = (next - nu).abs();
        nu = next;
        if moved < 1e-12 * nu {
            break;
        }
    }
    let variance = sums.error_square / sums.count.max(1.0);
    let correlated = (sums.count / (2.0 * sums.duration_s.max(1e-9)) * CORRELATION_S).max(1.0);
    FittedDeformation {
        deformation: nu,
        standard_error: (variance * correlated / sums.slope_square.max(f64::MIN_POSITIVE)).sqrt(),
        rms_kpa: variance.sqrt(),
    }
}

#[derive(Default)]
struct Sums {
    slope_error: f64,
    slope_square: f64,
    error_square: f64,
    count: f64,
    duration_s: f64,
}

fn add(sums: &mut Sums, subject: &Subject, geometry: &MuscleGeometry, nu: f64) {
    let r = &subject.recording;
    let dual = Dual64::new(nu, 1.0);
    let volumes = |x: f64| {
        let v = geometry.volumes(Dual64::constant(x), dual);
        [v.flexor_mm3, v.extensor_mm3]
    };
    let start = volumes(r.displacement_mm[0]);
    let columns = [&r.pressure_flexor_kpa, &r.pressure_extensor_kpa];
    for (k, &x) in r.displacement_mm.iter().enumerate() {
        let now = volumes(x);
        for i in 0..2 {
            let predicted = start[i] / now[i] * columns[i][0];
            let error = columns[i][k] - predicted.re;
            sums.slope_error += predicted.eps * error;
            sums.slope_square += predicted.eps * predicted.eps;
            sums.error_square += error * error;
            sums.count += 1.0;
        }
    }
    let (from, to) = r.span_s();
    sums.duration_s += to - from;
}
