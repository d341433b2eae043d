//! How long steps may be.
//!
//! The mechanics near an operating point is `δẍ = −s δx − d δẋ` with `s = (∂f/∂x)/m` and `d = (∂f/∂ẋ + B)/m`, hence two modes
//! `ẏ = λ y + u` with `λ = −d/2 ± √(d²/4 − s)`. A step of h multiplies a mode by the method's stability function `R(λh)`, and
//! answers a steady `u = exp(iωt)` with a gain that differs from `1/(iω − λ)`. Both are known numbers, so the step follows
//! from what is asked: modes that die out, and the right gain up to the highest frequency of the motion. The gain's
//! error bounds that of a resonance's frequency, too: the gain has its pole there.

use super::base::BaseForce;
use super::integrator::JointIntegrator;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Longest step, s: four samples of a log at 1 kHz, 31 steps in a period of 8 Hz.
pub(super) const LONGEST_S: f64 = 4e-3;
/// Highest frequency of the motion at which the gain has to be right, Hz: the published loader reaches 8 Hz.
const HIGHEST_HZ: f64 = 10.0;
/// Relative error of the gain there.
const GAIN_ERROR: f64 = 1e-4;
/// Most that a dying mode may keep in a step: a margin to the limit 1 of stability.
const LARGEST_KEPT: f64 = 0.95;
/// Most substeps of a step of the grid. Faster mechanics is not resolved: it diverges, and the simulation says so.
const MOST: usize = 32;

/// Substeps of each step of the grid for a joint, with its effects at their present values: a power of two, so that
/// small changes of the values seldom change it.
pub(crate) fn substeps<F: BaseForce<f64>>(joint: &mut JointIntegrator<'_, f64, F>) -> usize {
    let record = joint.record();
    let (h, highest_hz) = (record.fine_step_s(), HIGHEST_HZ.min(0.5 / record.sample_s));
    let slopes: Vec<[f64; 2]> =
        record.operating_points().map(|[x, v]| joint.slopes(x, v)).collect();
    let modes: Vec<Complex64> = slopes.into_iter().flat_map(modes_of).collect();
    let mut substeps = 1;
    while substeps < MOST
        && !modes.iter().all(|&mode| is_right(mode, h / substeps as f64, highest_hz))
    {
        substeps *= 2;
    }
    substeps
}

/// The modes (1/s) for slopes of the acceleration along displacement (1/s²) and velocity (1/s).
fn modes_of([by_x, by_v]: [f64; 2]) -> [Complex64; 2] {
    let root = Complex64::new(0.25 * by_v * by_v + by_x, 0.0).sqrt();
    [root, -root].map(|root| 0.5 * by_v + root)
}

/// Whether steps of `h` follow a mode: it dies out if it should, and has the right gain.
fn is_right(mode: Complex64, h: f64, highest_hz: f64) -> bool {
    if !mode.is_finite() {
        // Nothing is known of it.
        return true;
    }
    let rate = Complex64::new(0.0, TAU * highest_hz);
    let (kept, added) = step_of(mode, rate, h);
    let gain = added / ((rate * h).exp() - kept);
    let exact = (rate - mode).inv();
    // A mode that is slow as measured by the step is kept nearly whole, by right.
    let dies = kept.norm() <= LARGEST_KEPT.max((mode * h).exp().norm() * (1.0 + GAIN_ERROR));
    dies && (gain - exact).norm() <= GAIN_ERROR * exact.norm()
}

/// A Runge–Kutta step of fourth order for `ẏ = λ y + exp(iωt)`: the factor of y, and what is added.
fn step_of(mode: Complex64, rate: Complex64, h: f64) -> (Complex64, Complex64) {
    let z = mode * h;
    let kept = 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)));
    let [middle, end] = [0.5, 1.0].map(|share| (rate * (h * share)).exp());
    let sum =
        1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 2.0)) + middle * (4.0 + z * (2.0 + z / 2.0)) + end;
    (kept, sum * (h / 6.0))
}
