//! How long steps may be.
//!
//! The mechanics near an operating point is `δẍ = −s δx − d δẋ` with `s = (∂f/∂x)/m` and `d = (∂f/∂ẋ + B)/m`, hence two modes
//! `ẏ = λ y + u` with `λ = −d/2 ± √(d²/4 − s)`. A step of h multiplies a mode by the method's stability function `R(λh)`, and
//! answers a steady `u = exp(iωt)` with a gain that differs from `1/(iω − λ)`. Both are known numbers, so the step follows
//! from two requirements: decaying modes decay, and the gain is accurate at the frequencies of the measured motion. The gain's
//! error bounds that of a resonance's frequency, too: the gain has its pole there.
//! In fast motions a force with kinks may need shorter steps, which [`halving`](super::halving) finds.

use super::base::BaseForce;
use super::integrator::JointIntegrator;
use super::spectrum::Band;
use num_complex::Complex64;

/// Longest step, s: four samples of a log at 1 kHz, 31 steps in a period of 8 Hz.
pub(super) const LONGEST_S: f64 = 4e-3;
/// Largest relative error of the motion due to the error of the gain, as root mean square over the spectrum of the motion: 10 nm of
/// 1 mm, a fiftieth of a step of the finest encoder.
const GAIN_ERROR: f64 = 1e-5;
/// Relative tolerance of the growth factor of a mode in a step, for modes that decay slowly or grow.
const KEPT_ERROR: f64 = 1e-4;
/// Most that a dying mode may keep in a step: a margin to the limit 1 of stability.
const LARGEST_KEPT: f64 = 0.95;
/// Most substeps of a step of the grid. Faster mechanics is not resolved: it diverges, and the simulation says so.
const MOST: usize = 32;

/// Substeps of each step of the grid for a joint, with its effects at their present values: a power of two, so that
/// small changes of the values seldom change it.
pub(crate) fn substeps<F: BaseForce<f64>>(joint: &mut JointIntegrator<'_, f64, F>) -> usize {
    let record = joint.record();
    let h = record.fine_step_s();
    let slopes: Vec<[f64; 2]> =
        record.operating_points().map(|[x, v]| joint.slopes(x, v)).collect();
    let modes: Vec<Complex64> = slopes.into_iter().flat_map(modes_of).collect();
    let mut substeps = 1;
    while substeps < MOST && !are_right(&modes, h / substeps as f64, record.spectrum.bands()) {
        substeps *= 2;
    }
    substeps
}

/// The modes (1/s) for slopes of the acceleration along displacement (1/s²) and velocity (1/s).
fn modes_of([by_x, by_v]: [f64; 2]) -> [Complex64; 2] {
    let root = Complex64::new(0.25 * by_v * by_v + by_x, 0.0).sqrt();
    [root, -root].map(|root| 0.5 * by_v + root)
}

/// Whether steps of `h` follow the modes: each dies out if it should, and has the right gains.
fn are_right(modes: &[Complex64], h: f64, bands: &[Band]) -> bool {
    let drives: Vec<Drive> = bands.iter().map(|band| Drive::new(band, h)).collect();
    modes.iter().all(|&mode| {
        if !mode.is_finite() {
            // Nothing is known of it.
            return true;
        }
        let z = mode * h;
        let kept = 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)));
        // A mode that is slow as measured by the step is kept nearly whole, by right.
        let dies = kept.norm() <= LARGEST_KEPT.max(z.exp().norm() * (1.0 + KEPT_ERROR));
        let squares = drives.iter().map(|drive| drive.share * drive.error(mode, kept, h).powi(2));
        dies && squares.sum::<f64>() <= GAIN_ERROR * GAIN_ERROR
    })
}

/// A drive `exp(iωt)`, as a step sees it.
struct Drive {
    /// Share of the motion's power.
    share: f64,
    /// `iω`, 1/s.
    rate: Complex64,
    /// The drive in the middle and at the end of a step, relative to its start.
    middle: Complex64,
    end: Complex64,
}

impl Drive {
    fn new(band: &Band, h: f64) -> Self {
        let rate = Complex64::new(0.0, band.rate);
        let [middle, end] = [0.5, 1.0].map(|part| (rate * (h * part)).exp());
        Self { share: band.share, rate, middle, end }
    }

    /// The relative error of a mode's gain by Runge–Kutta steps of fourth order for `ẏ = λ y + exp(iωt)`, which keep `kept` of y.
    fn error(&self, mode: Complex64, kept: Complex64, h: f64) -> f64 {
        let z = mode * h;
        let start = 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 2.0));
        let sum = start + self.middle * (4.0 + z * (2.0 + z / 2.0)) + self.end;
        let gain = sum * (h / 6.0) / (self.end - kept);
        let exact = (self.rate - mode).inv();
        (gain - exact).norm() / exact.norm()
    }
}
