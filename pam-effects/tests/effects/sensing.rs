//! What the sensors show.

use crate::support::complex::{Complex, line};
use crate::support::joint::HOLD;
use crate::support::joint::{P, Run, driven, linear, linear_run, plain, run, subject, volumes};
use pam_core::units::ATMOSPHERE_KPA;
use pam_data::MassOrigin;
use pam_effects::effects::{DataScales, by_id};
use std::f64::consts::TAU;

const HERTZ: f64 = 1.0;

fn drive(t: f64) -> f64 {
    120.0 * (TAU * HERTZ * t).sin()
}

fn by_law(x: f64, effects: &[(&str, &[f64])]) -> Run {
    let model = linear();
    run(&model, &subject(&model, driven(8.0, x, drive), MassOrigin::GasLaw), effects)
}

/// Ratio of the pressures' Fourier lines with an effect to those without, at a harmonic.
fn transfer(effects: &[(&str, &[f64])], harmonic: f64) -> [Complex; 2] {
    let plain = linear_run(8.0, 0.0, drive, &[]);
    let seen = linear_run(8.0, 0.0, drive, effects);
    let of =
        |run: &Run, i: usize| line(&run.p[i], run.step_s, HERTZ * harmonic, 3 * harmonic as usize);
    [0, 1].map(|i| of(&seen, i) / of(&plain, i))
}

/// `1/(1 + j f/f_c)`, at the fundamental and at the second harmonic that the volumes make. The lag is exact for
/// straight lines between grid points: (ω h)²/12.
#[test]
fn the_lag_is_a_first_order_low_pass() {
    for cutoff in [1.0, 3.0, 10.0] {
        for harmonic in [1.0, 2.0] {
            let expected = Complex::real(1.0) / Complex(1.0, HERTZ * harmonic / cutoff);
            for ratio in transfer(&[("pressure_sensor_lag", &[cutoff])], harmonic) {
                let miss = (ratio + expected * Complex::real(-1.0)).size();
                assert!(miss < 5e-4, "{cutoff} Hz, harmonic {harmonic}: {miss}");
            }
        }
    }
}

/// `exp(−j ω d)`, between grid points by straight lines: (ω h)²/8.
#[test]
fn the_delay_turns_the_phase_and_keeps_the_amplitude() {
    for delay in [3.0, 25.0, 40.0] {
        for harmonic in [1.0, 2.0] {
            let expected = Complex::turn(-TAU * HERTZ * harmonic * 1e-3 * delay);
            for ratio in transfer(&[("pressure_delay", &[delay])], harmonic) {
                let miss = (ratio + expected * Complex::real(-1.0)).size();
                assert!(miss < 5e-4, "{delay} ms, harmonic {harmonic}: {miss}");
            }
        }
    }
}

/// Measured gauge is `(1 + r)` times true gauge, also in the sealed reading from which the masses follow: the
/// swing is `(1 + r)` times that of the true, smaller or larger, mass.
#[test]
fn pressure_gain_acts_on_gauge_pressures() {
    let relative = [0.1, -0.06];
    let plain = by_law(0.0, &[]);
    let seen = by_law(0.0, &[("pressure_gain", &relative)]);
    for (i, relative) in relative.into_iter().enumerate() {
        let gain = 1.0 + relative;
        let true_kpa = ATMOSPHERE_KPA + (P - ATMOSPHERE_KPA) / gain;
        for k in 0..plain.x.len() {
            let expected = P + (plain.p[i][k] - P) * gain * true_kpa / P;
            assert!((seen.p[i][k] - expected).abs() < 1e-9 * P, "{k}");
        }
    }
}

/// Offset: the joint is at `measured − o`. A linear joint that is really at rest at zero shows `x + o`.
#[test]
fn a_position_offset_is_added_to_the_true_position() {
    let plain = by_law(0.0, &[]);
    let seen = by_law(0.15, &[("position_offset", &[0.15])]);
    for k in 0..plain.x.len() {
        assert!((seen.x[k] - plain.x[k] - 0.15).abs() < 1e-9);
        assert!((seen.v[k] - plain.v[k]).abs() < 1e-9);
        // True volumes: as if sealed at zero, to the same pressures.
        assert!((seen.p[0][k] - plain.p[0][k]).abs() < 1e-9 * P, "{k}");
    }
}

/// Gain: measured displacement and velocity are `(1 + r)` times the true ones, the air knows the true ones.
#[test]
fn a_position_gain_multiplies_the_true_position() {
    let plain = by_law(0.0, &[]);
    let seen = by_law(0.0, &[("position_gain", &[0.08])]);
    let nu = linear().physical().deformation;
    let (rest, _) = volumes(0.0, nu);
    for k in 0..plain.x.len() {
        assert!((seen.x[k] - 1.08 * plain.x[k]).abs() < 1e-9);
        assert!((seen.v[k] - 1.08 * plain.v[k]).abs() < 1e-9);
        let (now, _) = volumes(seen.x[k] / 1.08, nu);
        assert!((seen.p[0][k] - P * rest[0] / now[0]).abs() < 1e-9 * P);
    }
}

/// A bias of the sensors shifts every sample by itself.
#[test]
fn a_pressure_bias_is_added() {
    // The rest of the measured first sample is true pressure and bias; nothing moves.
    let model = linear();
    let still = subject(&model, driven(6.0, 0.0, |_| 0.0), MassOrigin::GasLaw);
    let seen = run(&model, &still, &[("pressure_bias", &[12.0, -7.0])]);
    for series in &seen.p {
        assert!(series.iter().all(|p| (p - P).abs() < 1e-9 * P));
    }
}

/// The real force is the commanded one times `1/(1 + j f/f_c)`: amplitude and phase of the answer.
#[test]
fn the_actuator_lag_is_a_first_order_low_pass_of_the_force() {
    for hertz in [0.5, 2.0, 6.0] {
        for cutoff in [1.0, 3.0, 30.0, 200.0] {
            let rate = TAU * hertz;
            let run =
                linear_run(6.0, 0.0, |t| 100.0 * (rate * t).sin(), &[("actuator_lag", &[cutoff])]);
            let lag = Complex::real(100.0) / Complex(1.0, hertz / cutoff);
            let answer = lag * plain(rate);
            let miss = run.distance(|t| answer.at(rate, t - HOLD));
            println!("{hertz} Hz, {cutoff} Hz: {:.1e}", miss / answer.size());
            assert!(miss < 1e-3 * answer.size(), "{hertz} Hz, {cutoff} Hz: {miss}");
        }
    }
}

/// A held command of 40 N from the start is there at once: the lag starts in the steady state of the first command.
#[test]
fn the_actuator_lag_starts_with_the_first_command() {
    let held = linear_run(6.0, 0.0, |_| 40.0, &[("actuator_lag", &[2.0])]);
    let plain = linear_run(6.0, 0.0, |_| 40.0, &[]);
    assert!(held.x.iter().zip(&plain.x).all(|(a, b)| (a - b).abs() < 1e-12));
}

/// Displacement and velocity through `1/(1 + j f/f_c)`; the joint itself and its pressures do not change.
#[test]
fn the_position_lag_is_a_first_order_low_pass() {
    for cutoff in [1.0, 6.0, 40.0] {
        let plain = linear_run(8.0, 0.0, drive, &[]);
        let seen = linear_run(8.0, 0.0, drive, &[("position_sensor_lag", &[cutoff])]);
        let of = |series: &[f64]| line(series, plain.step_s, HERTZ, 3);
        let expected = Complex::real(1.0) / Complex(1.0, HERTZ / cutoff);
        for (seen, plain) in [(&seen.x, &plain.x), (&seen.v, &plain.v)] {
            let miss = (of(seen) / of(plain) + expected * Complex::real(-1.0)).size();
            assert!(miss < 5e-4, "{cutoff} Hz: {miss}");
        }
        assert_eq!(seen.p, plain.p);
    }
}

/// The reading is that of `delay` ago, to the last bit where the delay is a number of steps; it stands at the start before.
#[test]
fn the_position_delay_shifts_samples() {
    let plain = linear_run(6.0, 0.1, drive, &[]);
    let steps = 3;
    let ms = 1e3 * plain.step_s * steps as f64;
    let seen = linear_run(6.0, 0.1, drive, &[("position_delay", &[ms])]);
    for k in 0..plain.x.len() {
        let then = k.saturating_sub(steps);
        assert!((seen.x[k] - plain.x[then]).abs() < 1e-12, "{k}");
        assert!((seen.v[k] - plain.v[then]).abs() < 1e-10, "{k}");
    }
    assert_eq!(seen.p, plain.p);
}

/// A limit at the amplitude of a sine cuts the noise of its sensor off and is no saturation; one below it is.
#[test]
fn a_limit_that_cuts_noise_is_no_saturation() {
    let amplitude_n = 100.0;
    // Two incommensurate sines in place of noise, with a root mean square of 3 N.
    let noise = |k: f64| 3.0 * ((1.7 * k).sin() + (2.9 * k).sin());
    let mut sizes: Vec<f64> = (0..2000)
        .map(f64::from)
        .map(|k| (amplitude_n * (0.01 * k).sin() + noise(k)).abs())
        .collect();
    sizes.sort_by(f64::total_cmp);
    let scales = DataScales {
        force_n: amplitude_n,
        peak_force_n: sizes[1995],
        force_quantiles_n: sizes,
        travel_mm: 1.0,
        reach_mm: 1.0,
        speed_mm_s: 6.0,
        stiffness_n_mm: 150.0,
        gauge_kpa: 310.0,
        duration_s: 20.0,
        samples: Vec::new(),
    };
    let effect = by_id("force_saturation").expect("an id");
    let stands = |limit_n: f64| effect.stands(&[limit_n], &scales);
    assert!([50.0, 82.5, 90.0].into_iter().all(stands));
    assert!(![98.0, 100.0, 103.0].into_iter().any(stands));
}
