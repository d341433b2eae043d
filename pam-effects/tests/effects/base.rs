//! The simulation without effects.

use crate::support::joint::{HOLD, linear_run, plain};
use std::f64::consts::TAU;

/// Steps of 4 ms, a force averaged over 2 ms: the motion at 2 Hz is right to 1e-4 of its amplitude.
#[test]
fn a_linear_joint_answers_as_its_transfer_function_says() {
    for hertz in [0.5, 2.0] {
        let rate = TAU * hertz;
        let run = linear_run(6.0, 0.0, |t| 100.0 * (rate * t).sin(), &[]);
        let amplitude = 100.0 * plain(rate).size();
        let expected = |t: f64| 100.0 * plain(rate).at(rate, t - HOLD);
        assert!(
            run.distance(expected) < 1e-4 * amplitude,
            "{hertz} Hz: {}",
            run.distance(expected)
        );
    }
}

/// Free oscillation without damping keeps its amplitude: the march neither damps nor drives. Over 6 s (21
/// periods, ω h = 0.1) a fourth-order method loses (ω h)⁶/144 a step, 1e-5 in all.
#[test]
fn free_motion_keeps_its_energy() {
    use crate::support::joint::{K, M, driven, run, subject, undamped};
    let model = undamped();
    let subject = subject(&model, driven(6.0, 0.5, |_| 0.0), pam_data::MassOrigin::Given);
    let free = run(&model, &subject, &[]);
    let energy = |k: usize| 0.5 * (K * free.x[k].powi(2) + M * free.v[k].powi(2));
    let last = free.x.len() - 1;
    assert!((energy(last) / energy(0) - 1.0).abs() < 1e-4, "{}", energy(last) / energy(0));
}
