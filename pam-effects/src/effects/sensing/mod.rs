//! Effects between command and force, and between joint and record.

pub(super) mod actuation_delay;
pub(super) mod actuator_lag;
pub(super) mod force_gain;
pub(super) mod force_saturation;
pub(super) mod position_delay;
pub(super) mod position_gain;
pub(super) mod position_offset;
pub(super) mod position_sensor_lag;
pub(super) mod pressure_bias;
pub(super) mod pressure_delay;
pub(super) mod pressure_gain;
pub(super) mod pressure_sensor_lag;

use pam_core::Scalar;

/// Output of the low-pass `dy/dτ = u − y` after `rate` of its time constants, in which its input went from `before` to
/// `now` on a straight line; exact for that input.
fn low_pass_step<S: Scalar>(rate: S, before: S, now: S, state: S) -> S {
    let gone = -(-rate).exp_m1();
    now - (gone / rate) * (now - before) + (S::constant(1.0) - gone) * (state - before)
}

/// A series through the low-pass, `rate` time constants between two values, in its steady state at the start.
fn low_passed<S: Scalar>(rate: S, series: &mut [S]) {
    let gone = -(-rate).exp_m1();
    let (ramp, keep) = (gone / rate, S::constant(1.0) - gone);
    let (mut state, mut before) = (series[0], series[0]);
    for value in series {
        let now = *value;
        state = now - ramp * (now - before) + keep * (state - before);
        before = now;
        *value = state;
    }
}

/// A series `steps` later, by straight lines between its values; before its start, its first value.
pub(crate) fn delayed<S: Scalar>(steps: S, series: &mut [S]) {
    let whole = steps.real().floor();
    let part = steps - S::constant(whole);
    let whole = whole as usize;
    let first = series[0];
    for k in (0..series.len()).rev() {
        let at = |back: usize| if back <= k { series[k - back] } else { first };
        let (near, far) = (at(whole), at(whole + 1));
        series[k] = near + part * (far - near);
    }
}
