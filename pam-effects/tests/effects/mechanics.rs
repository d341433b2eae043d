//! Smooth forces and the observation of position.

use crate::support::complex::Complex;
use crate::support::joint::{B, HOLD, K, M, answer, linear_run, plain};
use std::f64::consts::{FRAC_PI_2, TAU};

const RATE: f64 = TAU;
const FORCE_N: f64 = 100.0;

fn sine(t: f64) -> f64 {
    FORCE_N * (RATE * t).sin()
}

/// Largest distance, relative to the amplitude of the plain motion, from a sinusoid around a middle.
fn misses(effects: &[(&str, &[f64])], middle: f64, amplitude: Complex) -> f64 {
    let run = linear_run(6.0, 0.0, sine, effects);
    run.distance(|t| middle + FORCE_N * amplitude.at(RATE, t - HOLD))
        / (FORCE_N * plain(RATE).size())
}

#[test]
fn a_steady_load_shifts_the_middle_by_force_over_stiffness() {
    let miss = misses(&[("constant_load", &[15.0])], 15e3 / K, plain(RATE));
    assert!(miss < 1e-4, "{miss}");
}

#[test]
fn damping_and_inertia_add_to_the_model_s() {
    let spring = Complex::real(K);
    for c in [-2000.0, 3000.0] {
        let miss = misses(&[("viscous_damping", &[c])], 0.0, answer(spring, B + c, M, RATE));
        assert!(miss < 1e-4, "damping {c}: {miss}");
    }
    for mass in [-100.0, 150.0] {
        let miss = misses(&[("added_inertia", &[mass])], 0.0, answer(spring, B, M + mass, RATE));
        assert!(miss < 1e-4, "inertia {mass}: {miss}");
    }
}

/// The whole restoring force, K x + B ẋ, is scaled.
#[test]
fn stiffness_scale_multiplies_the_restoring_force() {
    let scaled = answer(Complex::real(1.2 * K), 1.2 * B, M, RATE);
    let miss = misses(&[("stiffness_scale", &[0.2])], 0.0, scaled);
    assert!(miss < 1e-4, "{miss}");
}

/// `(K x + B ẋ)(1 + r t/60) = F` at a constant force; the next term of the slow expansion is (B/K)² r² x, 1e-7.
#[test]
fn stiffness_drift_grows_with_time() {
    let (rate, force) = (0.6, 120e3);
    let run = linear_run(20.0, force / K, |_| force / 1e3, &[("stiffness_drift", &[rate])]);
    let expected = |t: f64| {
        let grown = 1.0 + rate * t / 60.0;
        force / (K * grown) + B / (K * K) * force * (rate / 60.0) / (grown * grown)
    };
    assert!(run.distance(expected) < 1e-5 * force / K, "{}", run.distance(expected));
}

/// A spring and a damper in series beside the joint: `κ jωτ/(1 + jωτ)` more stiffness. The memory is moved
/// with the mean of each step, an error of (h/τ)²/12.
#[test]
fn creep_has_the_dynamic_stiffness_of_a_maxwell_element() {
    for tau in [0.05, 0.4] {
        let part = Complex(0.0, RATE * tau);
        let element = Complex::real(20e3) * part / (Complex::real(1.0) + part);
        let more = answer(Complex::real(K) + element, B, M, RATE);
        let miss = misses(&[("creep", &[20.0, tau])], 0.0, more);
        assert!(miss < 5e-4, "{tau}: {miss}");
    }
}

/// At rest under a steady force, `K x + c sin(2π x/p) = F`.
#[test]
fn cogging_moves_the_place_of_rest() {
    let (c, pitch) = (10e3, 0.6);
    for force in [20e3, 60e3, -35e3] {
        let run = linear_run(6.0, 0.0, |_| force / 1e3, &[("cogging", &[c / 1e3, pitch])]);
        let balance = |x: f64| K * x + c * (TAU * x / pitch).sin() - force;
        // The slope K + 2π c/p cos is positive everywhere, so one root.
        let (mut low, mut high) = (-2.0, 2.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if balance(middle) > 0.0 { high = middle } else { low = middle }
        }
        let at = *run.x.last().expect("points");
        assert!((at - low).abs() < 1e-6, "{force}: {at} {low}");
    }
}

/// Beyond d the stiffness is `(1 − loss) K`.
#[test]
fn slack_takes_its_share_of_the_stiffness() {
    let (d, loss, force) = (0.4, 0.3, 90e3);
    for sign in [-1.0, 1.0] {
        let run = linear_run(6.0, 0.0, |_| sign * force / 1e3, &[("tendon_slack", &[d, loss])]);
        let expected = sign * (d + (force - K * d) / ((1.0 - loss) * K));
        let at = *run.x.last().expect("points");
        assert!((at - expected).abs() < 1e-6, "{at} {expected}");
    }
    let inside = linear_run(6.0, 0.0, |_| 30.0, &[("tendon_slack", &[d, loss])]);
    assert!((inside.x.last().expect("points") - 30e3 / K).abs() < 1e-6);
}

/// The encoder lags by half the gap while it is pushed and rests at the turns: for `A sin`, it is at
/// `min(A − g/2, x + g/2)` on the way down and at `max(−A + g/2, x − g/2)` on the way up.
#[test]
fn backlash_is_the_play_operator() {
    let gap = 0.2;
    let joint = linear_run(6.0, 0.0, sine, &[]);
    let seen = linear_run(6.0, 0.0, sine, &[("backlash", &[gap])]);
    let amplitude = FORCE_N * plain(RATE).size();
    for k in joint.settled() {
        let x = joint.x[k];
        let expected = if joint.v[k] < 0.0 {
            (x + 0.5 * gap).min(amplitude - 0.5 * gap)
        } else {
            (x - 0.5 * gap).max(0.5 * gap - amplitude)
        };
        // The values of the grid miss the top by up to A (ω h/2)²/2; the turn between them is found.
        let grid = 0.05 * amplitude * (RATE * 0.5 * joint.step_s).powi(2);
        assert!((seen.x[k] - expected).abs() < grid, "{k}: {} {expected}", seen.x[k]);
    }
}

/// The record shows the derivative of what the encoder shows: standing still in the play.
#[test]
fn the_velocity_behind_a_play_is_that_of_the_encoder() {
    let seen = linear_run(6.0, 0.0, sine, &[("backlash", &[0.3])]);
    for k in seen.settled().skip(1).take(500) {
        let slope = (seen.x[k + 1] - seen.x[k - 1]) / (2.0 * seen.step_s);
        assert!((seen.v[k] - slope).abs() < 1e-9);
    }
    let still = seen.settled().filter(|&k| seen.v[k] == 0.0).count();
    assert!(still > 100, "{still}");
}

/// `f (1 + r)`, `f(t − d)`.
#[test]
fn the_force_is_scaled_and_delayed() {
    let gained = Complex::real(0.85) * plain(RATE);
    assert!(misses(&[("force_gain", &[-0.15])], 0.0, gained) < 1e-4);
    for ms in [0.7, 13.0, 40.0] {
        let late = plain(RATE) * Complex::turn(-RATE * 1e-3 * ms);
        let miss = misses(&[("actuation_delay", &[ms])], 0.0, late);
        assert!(miss < 1e-4, "{ms}: {miss}");
    }
}

/// A sine clipped at `c A`, `φ = asin c`, has odd harmonics
/// `b_1 = (2A/π)(φ + c cos φ)`,
/// `b_k = (4A/π) [c cos(kφ)/k + ½ (sin((k−1)φ)/(k−1) − sin((k+1)φ)/(k+1))]`.
#[test]
fn a_clipped_force_has_the_harmonics_of_a_clipped_sine() {
    let limit = 65.0;
    let run = linear_run(6.0, 0.0, sine, &[("force_saturation", &[limit])]);
    let c: f64 = limit / FORCE_N;
    let phi = c.asin();
    let harmonic = |k: usize| {
        let k = k as f64;
        let rising = if k == 1.0 {
            0.5 * (phi - 0.5 * (2.0 * phi).sin())
        } else {
            0.5 * (((k - 1.0) * phi).sin() / (k - 1.0) - ((k + 1.0) * phi).sin() / (k + 1.0))
        };
        FORCE_N / FRAC_PI_2 * 2.0 * (c * (k * phi).cos() / k + rising)
    };
    let expected = |t: f64| -> f64 {
        let one = |k: usize| {
            let rate = RATE * k as f64;
            harmonic(k) * plain(rate).at(rate, t - HOLD)
        };
        (1..80).step_by(2).map(one).sum()
    };
    // The corner falls between grid points: 1e-4 of the amplitude.
    let miss = run.distance(expected) / (FORCE_N * plain(RATE).size());
    assert!(miss < 2e-4, "{miss}");
}
