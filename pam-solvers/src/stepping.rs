//! What every step loop decides alike: whether a step ends at a stop, and how long the first step is.

use crate::controller::Tolerances;
use pam_core::Scalar;

/// A step this close to a stop, relative to its size, ends at the stop.
const STOP_SLACK: f64 = 1e-6;

/// Whether a step of `h` from `t` ends at `stop`.
#[inline]
pub(crate) fn reaches(t: f64, h: f64, stop: f64) -> bool {
    t + h * (1.0 + STOP_SLACK) >= stop
}

/// The Euler step of trial for [`first_step`], from the sizes of state `y` and derivative `k`.
pub(crate) fn probe_step<S: Scalar>(tolerances: &Tolerances, y: &[S], k: &[S], span: f64) -> f64 {
    let (d0, d1) = (tolerances.norm(y, y, y), tolerances.norm(k, y, y));
    let h0 = if d0 < 1e-5 || d1 < 1e-5 { 1e-6 } else { 0.01 * d0 / d1 };
    h0.min(span)
}

/// First step from the sizes of state, derivative and second derivative; `change` is how the
/// derivative changed over the trial step `h0` (Hairer, Nørsett and Wanner, *Solving Ordinary
/// Differential Equations I*, section II.4).
pub(crate) fn first_step<S: Scalar>(
    tolerances: &Tolerances,
    y: &[S],
    k: &[S],
    change: &[S],
    (h0, span): (f64, f64),
    order: usize,
) -> f64 {
    let d1 = tolerances.norm(k, y, y);
    let d2 = tolerances.norm(change, y, y) / h0;
    let largest = d1.max(d2);
    let h1 = if largest <= 1e-15 {
        (h0 * 1e-3).max(1e-6)
    } else {
        (0.01 / largest).powf(1.0 / order as f64)
    };
    let h = h1.min(100.0 * h0);
    if h.is_finite() && h > 0.0 { h.min(span) } else { h0 }
}
