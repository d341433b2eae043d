//! Steps of the simulation: stability for any mass, and recordings of any rate.

use crate::support::complex::Complex;
use crate::support::joint::{B, Joint, K, M, P, Run, SETTLED_S, answer, linear, run, subject};
use pam_core::PhysicalParameters;
use pam_data::{MassOrigin, Recording, Subject};
use pam_effects::simulation::{Base, Nuisances, ResampledRecord, Trajectory, Trial, simulate};
use std::f64::consts::TAU;

fn of_mass(mass_kg: f64) -> Joint {
    let mut model = linear();
    model.raw = PhysicalParameters { mass_kg, ..model.physical() }.to_raw();
    model
}

/// A recording of 6 s at `rate_hz` of a sine force of 100 N whose samples are its values, and a made-up channel.
fn sampled(rate_hz: f64, hertz: f64) -> Recording {
    let count = (6.0 * rate_hz).round() as usize + 1;
    let time_s: Vec<f64> = (0..count).map(|k| k as f64 / rate_hz).collect();
    Recording {
        displacement_mm: vec![0.0; count],
        velocity_mm_s: vec![0.0; count],
        pressure_flexor_kpa: (0..count).map(|k| P + (k % 7) as f64 * 1e-3).collect(),
        pressure_extensor_kpa: vec![P; count],
        force_mn: time_s.iter().map(|t| 1e5 * (TAU * hertz * t).sin()).collect(),
        time_s,
        ..Recording::empty("made_up")
    }
}

fn made(model: &Joint, rate_hz: f64, hertz: f64) -> Subject {
    subject(model, sampled(rate_hz, hertz), MassOrigin::Given)
}

/// Images of the motion's frequency about the multiples of the sampling rate, on either side: those left out are below
/// 10⁻⁵ of the answer at 10 Hz.
const IMAGES: i32 = 40;

/// Largest distance from the answer to a held force, as a share of its amplitude.
///
/// A held sine is a sum of sines at `ω + 2πn` times the rate, each `(1 − e^{−iωT})/(iωT)` large: sinc, half a sample late.
fn miss(run: &Run, mass_kg: f64, rate_hz: f64, hertz: f64) -> f64 {
    let answers: Vec<(f64, Complex)> = (-IMAGES..=IMAGES)
        .map(|n| {
            let rate = TAU * (hertz + f64::from(n) * rate_hz);
            let half = 0.5 * rate / rate_hz;
            let held = Complex::real(100.0 * half.sin() / half) * Complex::turn(-half);
            (rate, held * answer(Complex::real(K), B, mass_kg, rate))
        })
        .collect();
    let expected = |t: f64| answers.iter().map(|(rate, a)| a.at(*rate, t)).sum::<f64>();
    let settled = (SETTLED_S / run.step_s) as usize..run.x.len();
    let at = |k: usize| (run.x[k] - expected(run.time_s(k))).abs();
    settled.map(at).fold(0.0, f64::max) / answers[IMAGES as usize].1.size()
}

/// With steps of 4 ms a mass below 8 kg would be unstable: `B/m · 4 ms > 2.8`.
#[test]
fn light_joints_are_stable() {
    for mass_kg in [0.5, 3.0, 8.0, 39.0, 254.0, 600.0] {
        let model = of_mass(mass_kg);
        let run = run(&model, &made(&model, 1000.0, 2.0), &[]);
        let miss = miss(&run, mass_kg, 1000.0, 2.0);
        println!("{mass_kg} kg: {miss:.1e}");
        assert!(miss < 2e-4, "{mass_kg} kg: {miss:e}");
    }
}

/// An effect that makes the mechanics faster makes the steps shorter: 2e4 N s/m on 8 kg is a mode of 3300/s.
#[test]
fn fast_effects_are_stable() {
    let model = of_mass(8.0);
    let damping = 2e4;
    let run = run(&model, &made(&model, 1000.0, 1.0), &[("viscous_damping", &[damping])]);
    let rate = TAU;
    let half = 0.5 * rate / 1000.0;
    let slow = answer(Complex::real(K), B + damping, 8.0, rate);
    let expected = Complex::real(100.0) * Complex::turn(-half) * slow;
    let miss = run.distance(|t| expected.at(rate, t)) / expected.size();
    assert!(miss < 2e-4, "{miss:e}");
}

/// Grid points are the samples themselves, unless several are averaged to one, and the simulation makes as many steps
/// between as it needs.
#[test]
fn every_rate_has_its_grid() {
    let model = linear();
    for (rate_hz, steps) in [(10.0, 25), (25.0, 10), (50.0, 5), (120.0, 3), (250.0, 1), (400.0, 1)]
    {
        let subject = made(&model, rate_hz, 0.5);
        let record = ResampledRecord::new(&subject);
        assert_eq!(record.steps_per_point, steps, "{rate_hz} Hz");
        assert!((record.step_s * rate_hz - 1.0).abs() < 1e-9, "{rate_hz} Hz");
        assert_eq!(record.points(), subject.recording.time_s.len(), "{rate_hz} Hz");
        for (ours, sample) in record.measured[2].iter().zip(&subject.recording.pressure_flexor_kpa)
        {
            assert!((ours - sample).abs() < 1e-9, "{rate_hz} Hz: {ours} {sample}");
        }
    }
    for rate_hz in [500.0, 1000.0, 2000.0, 10_000.0] {
        let record = ResampledRecord::new(&made(&model, rate_hz, 0.5));
        assert_eq!((record.step_s, record.steps_per_point), (4e-3, 1), "{rate_hz} Hz");
    }
}

/// Several samples that make one grid point lose nothing of a motion at 8 Hz, where a plain mean over 4 ms loses 1.7·10⁻³.
#[test]
fn averaged_samples_keep_the_amplitude() {
    let model = linear();
    for rate_hz in [500.0, 1000.0, 10_000.0] {
        let mut recording = sampled(rate_hz, 8.0);
        let motion = |t: f64| (TAU * 8.0 * t).sin();
        recording.displacement_mm = recording.time_s.iter().map(|&t| motion(t)).collect();
        let record = ResampledRecord::new(&subject(&model, recording, MassOrigin::Given));
        let inside = 1..record.points() - 1;
        let miss = |k: usize| (record.measured[0][k] - motion(record.step_s * k as f64)).abs();
        let miss = inside.map(miss).fold(0.0, f64::max);
        assert!(miss < 3e-5, "{rate_hz} Hz: {miss:e}");
    }
}

/// The same joint from recordings of any rate.
#[test]
fn every_rate_is_simulated() {
    let model = linear();
    let mass_kg = model.physical().mass_kg;
    for rate_hz in [10.0, 25.0, 50.0, 120.0, 250.0, 400.0, 1000.0, 10_000.0] {
        for hertz in [0.5, 1.0] {
            let run = run(&model, &made(&model, rate_hz, hertz), &[]);
            let miss = miss(&run, mass_kg, rate_hz, hertz);
            println!("{rate_hz} Hz of samples, {hertz} Hz of motion: {miss:.1e}");
            assert!(miss < 5e-6, "{rate_hz} Hz, {hertz} Hz: {miss:e}");
        }
    }
}

/// The answer to a step of the force is that of the oscillator, `F/K (1 − e^{−γτ}(cos ωτ + γ/ω sin ωτ))`, wherever between the steps
/// of the simulation the sample is at which it comes.
#[test]
fn a_jump_of_the_force_has_its_impulse() {
    let model = linear();
    // From N, N/m and kg to mm.
    let (decay, force_n) = (0.5 * B / M, 100.0);
    let settled_mm = 1e3 * force_n / K;
    let rate = (K / M - decay * decay).sqrt();
    for (rate_hz, jitter) in
        [(1000.0, 0.0), (2000.0, 0.0), (700.0, 0.0), (400.0, 0.0), (100.0, 0.0), (100.0, 0.2)]
    {
        let first = rate_hz as usize;
        for sample in first..first + 8 {
            let mut recording = sampled(rate_hz, 1.0);
            let last = recording.time_s.len() - 1;
            for (k, t) in recording.time_s.iter_mut().enumerate().take(last).skip(1) {
                *t += jitter / rate_hz * (1.7 * k as f64).sin();
            }
            let jump_s = recording.time_s[sample];
            for (k, force) in recording.force_mn.iter_mut().enumerate() {
                *force = if k < sample { 0.0 } else { 1e3 * force_n };
            }
            let run = run(&model, &subject(&model, recording, MassOrigin::Given), &[]);
            let answer = |t: f64| {
                let since = t - jump_s;
                let swing = (rate * since).cos() + decay / rate * (rate * since).sin();
                settled_mm * (1.0 - (-decay * since).exp() * swing)
            };
            // Past the filter of the values about the jump.
            let after = (1.2 / run.step_s) as usize..run.x.len();
            let miss = after.map(|k| (run.x[k] - answer(run.time_s(k))).abs());
            let miss = miss.fold(0.0, f64::max) / settled_mm;
            println!("{rate_hz} Hz, sample {sample}: {miss:.1e}");
            assert!(miss < 2e-4, "{rate_hz} Hz, sample {sample}: {miss:e}");
        }
    }
}

/// With a lead of half a sample the force is the smooth one that the samples are of.
#[test]
fn a_smooth_force_is_followed_between_sparse_samples() {
    let model = linear();
    for (rate_hz, hertz) in [(25.0, 1.0), (25.0, 2.0), (50.0, 2.0), (200.0, 4.0)] {
        let trial = Trial::new(&model, &made(&model, rate_hz, hertz));
        let nuisances = Nuisances { lead_samples: 0.5, ..Nuisances::none() };
        let mut out = Trajectory::default();
        simulate::<f64>(&trial, &Base::of(&model), &[], &[], &nuisances, &mut out)
            .expect("in range");
        let rate = TAU * hertz;
        let expected = Complex::real(100.0) * answer(Complex::real(K), B, M, rate);
        let step_s = trial.record.step_s;
        let settled = (SETTLED_S / step_s) as usize..out.channels[0].len();
        let at = |k: usize| (out.channels[0][k] - expected.at(rate, k as f64 * step_s)).abs();
        let miss = settled.map(at).fold(0.0, f64::max) / expected.size();
        println!("{rate_hz} Hz of samples, smooth force of {hertz} Hz: {miss:.1e}");
        assert!(miss < 2e-4, "{rate_hz} Hz: {miss:e}");
    }
}

/// A joint with dry friction, sampled at 25 and at 1000 Hz, moves alike: friction is resolved between samples.
#[test]
fn sparse_samples_do_not_change_the_friction() {
    let model = linear();
    let friction: &[(&str, &[f64])] = &[("coulomb_friction", &[20.0])];
    let sparse = run(&model, &made(&model, 25.0, 0.5), friction);
    let free = run(&model, &made(&model, 25.0, 0.5), &[]);
    let dense = run(&model, &made(&model, 1000.0, 0.5), friction);
    let every = (sparse.step_s / dense.step_s).round() as usize;
    // The force of 25 Hz is held longer: 19.5 ms later on average.
    let rate = TAU * 0.5;
    let late = 0.5 * rate * (1.0 / 25.0 - 1e-3);
    let rms = |f: &dyn Fn(usize) -> f64| sparse.settled().map(|k| f(k).powi(2)).sum::<f64>().sqrt();
    let effect = rms(&|k| sparse.x[k] - free.x[k]);
    let shift = (late / rate / dense.step_s).round() as usize;
    let miss = rms(&|k| sparse.x[k] - dense.x[k * every - shift]);
    println!("sparse friction: {:.1e}", miss / effect);
    assert!(miss < 0.05 * effect, "{}", miss / effect);
}
