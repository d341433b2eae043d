//! Rate-independent loops: their area over a cycle.

use crate::support::joint::{B, HOLD, K, driven, linear, run, subject};
use pam_data::MassOrigin;
use std::f64::consts::TAU;

/// Work that the effect takes in a cycle (mN·mm) at 0.5 Hz, and the amplitude (mm) of the motion.
fn cycle(force_n: f64, slip_mm: f64, shape: f64, drive_n: f64) -> (f64, f64) {
    let (hertz, model) = (0.5, linear());
    let drive = |t: f64| drive_n * (TAU * hertz * t).sin();
    let subject = subject(&model, driven(16.0, 0.0, drive), MassOrigin::Given);
    let run = run(&model, &subject, &[("hysteresis", &[force_n, slip_mm, shape])]);
    let count = (1.0 / (hertz * run.step_s)).round() as usize;
    let last = run.x.len() - 1 - count..run.x.len() - 1;
    let power = |k: usize| 1e3 * drive(run.time_s(k) - HOLD) * run.v[k] - B * run.v[k].powi(2);
    let work = last.clone().map(power).sum::<f64>() * run.step_s;
    let high = last.clone().map(|k| run.x[k]).fold(f64::MIN, f64::max);
    let low = last.map(|k| run.x[k]).fold(f64::MAX, f64::min);
    (work, 0.5 * (high - low))
}

/// Elements whose slip distances are spread evenly from 0 to s take `4 F ∫ max(A − d, 0) dd / s` a cycle, one element that slips
/// after s takes `4 F (A − s)`.
#[test]
fn slipping_elements_take_the_area_of_their_loops() {
    let force = 20.0;
    for (drive, slip) in [(60.0, 0.3), (120.0, 0.3), (60.0, 0.6), (60.0, 1.1)] {
        let (work, amplitude) = cycle(force, slip, 0.0, drive);
        let mean = if amplitude > slip {
            amplitude - 0.5 * slip
        } else {
            0.5 * amplitude * amplitude / slip
        };
        let expected = 4.0 * 1e3 * force * mean;
        assert!((work / expected - 1.0).abs() < 5e-3, "{drive} N: {}", work / expected);
        let slip = 0.1;
        let (work, amplitude) = cycle(force, slip, 100.0, drive);
        assert!(amplitude > slip, "{amplitude} mm");
        let expected = 4.0 * 1e3 * force * (amplitude - slip);
        assert!((work / expected - 1.0).abs() < 5e-3, "{drive} N: {}", work / expected);
    }
}

/// In a steady cycle of Bouc–Wen with β = γ = ½ the variable goes from −z to 0 on a straight line of length
/// s z and on to z along `1 − exp(−u)` (n = 1) or `tanh u` (n = 2) with `z + u(z) = 2A/s`, so that the half
/// loop encloses `s (u − z − z²/2)` or `s (ln cosh u − z²/2)`.
#[test]
fn bouc_wen_takes_the_area_of_its_loop() {
    let (force, slip) = (20.0, 0.3);
    for exponent in [1.0, 2.0] {
        for drive in [60.0, 120.0] {
            let (work, amplitude) = cycle(force, slip, exponent, drive);
            let way = |z: f64| if exponent == 1.0 { -(1.0 - z).ln() } else { z.atanh() };
            let (mut low, mut high) = (0.0, 1.0 - 1e-15);
            for _ in 0..80 {
                let z = 0.5 * (low + high);
                if z + way(z) > 2.0 * amplitude / slip { high = z } else { low = z }
            }
            let (z, u) = (low, way(low));
            let curved = if exponent == 1.0 { u - z } else { u.cosh().ln() };
            let expected = 2.0 * 1e3 * force * slip * (curved - 0.5 * z * z);
            assert!(
                (work / expected - 1.0).abs() < 5e-3,
                "n = {exponent}, {drive} N: {}",
                work / expected
            );
        }
    }
}

/// Far beyond the slip distance the force is F: on a slow ramp `K x + B ẋ = drive − F` with `ẋ = slope/K`.
#[test]
fn the_force_saturates_at_its_limit() {
    let slope = 25e3;
    for shape in [0.0, 1.0, 2.0, 100.0] {
        let model = linear();
        let command = driven(6.0, 0.0, |t| 1e-3 * slope * t);
        let subject = subject(&model, command, MassOrigin::Given);
        let run = run(&model, &subject, &[("hysteresis", &[20.0, 0.05, shape])]);
        let last = run.x.len() - 1;
        let drive = slope * (run.time_s(last) - HOLD);
        let expected = (drive - 20e3) / K - B * slope / (K * K);
        // What is left of Bouc and Wen after 0.8 mm is exp(−16); the last force is held to the end.
        assert!((run.x[last] - expected).abs() < 1e-5, "{shape}: {} {expected}", run.x[last]);
    }
}
