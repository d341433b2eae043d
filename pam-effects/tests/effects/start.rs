//! The velocity with which a simulation starts.

use pam_data::Recording;
use pam_effects::simulation::StartVelocity;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::f64::consts::{PI, TAU};

/// A 2 s recording of sinusoidal motion by a noisy encoder, with the gradient of its readings as velocity, and the true initial velocity.
fn recorded(rate_hz: f64, noise_mm: f64, step_mm: f64, rng: &mut ChaCha8Rng) -> (Recording, f64) {
    let h = 1.0 / rate_hz;
    let rate = TAU * rng.random_range(0.5..8.0);
    let amplitude = rng.random_range(0.0..15.0) / rate;
    let phase = rng.random_range(0.0..TAU);
    let mut normal = || {
        let [u, v] = [0, 1].map(|_| 1.0 - rng.random::<f64>());
        (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
    };
    let time_s: Vec<f64> = (0..(2.0 * rate_hz) as usize).map(|k| k as f64 * h).collect();
    let shown = |t: &f64| {
        let x = amplitude * (rate * t + phase).sin() + noise_mm * normal();
        if step_mm > 0.0 { (x / step_mm).round() * step_mm } else { x }
    };
    let x: Vec<f64> = time_s.iter().map(shown).collect();
    let last = x.len() - 1;
    let slope = |a: usize, b: usize| (x[b] - x[a]) / ((b - a) as f64 * h);
    let velocity_mm_s = (0..=last).map(|k| slope(k.saturating_sub(1), (k + 1).min(last)));
    let mut recording = Recording::at_rest("sine", time_s, [412.0; 2]);
    recording.velocity_mm_s = velocity_mm_s.collect();
    recording.displacement_mm = x;
    (recording, amplitude * rate * phase.cos())
}

/// The stated deviation is that of the errors, for noise and for steps of the encoder, and the slope of the first displacements is
/// nearer to the truth than their gradient by a factor of five and more.
#[test]
fn a_noisy_velocity_is_taken_from_the_first_displacements() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for (rate_hz, noise_mm, step_mm) in [
        (2000.0, 0.0067, 0.0),
        (2000.0, 0.0, 0.0105),
        (2000.0, 0.002, 0.005),
        (1000.0, 0.01, 0.001),
    ] {
        let (mut errors, mut gradients, mut within) = (0.0, 0.0, 0);
        let draws = 400;
        for _ in 0..draws {
            let (recording, truth) = recorded(rate_hz, noise_mm, step_mm, &mut rng);
            let start = StartVelocity::of(&recording, recording.resolution()[1]);
            let error = start.mm_s - truth;
            errors += error.powi(2);
            gradients += (recording.velocity_mm_s[0] - truth).powi(2);
            within += usize::from(error.abs() <= 2.0 * start.deviation_mm_s);
        }
        let better = (gradients / errors).sqrt();
        let case = format!("{rate_hz} Hz, noise {noise_mm}, steps {step_mm} mm");
        assert!(better > 5.0, "{case}: {better} times");
        assert!(within as f64 >= 0.93 * f64::from(draws), "{case}: {within} of {draws}");
    }
}

/// The noise that is stated for a quiet gradient is `√2 σ/h`, and its value stays as it was measured.
#[test]
fn a_quiet_velocity_stays() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let (mut errors, mut stated) = (0.0, 0.0);
    for _ in 0..400 {
        let (recording, _) = recorded(500.0, 0.0005, 0.0, &mut rng);
        let quiet = StartVelocity::of(&recording, recording.resolution()[1]);
        assert_eq!(quiet.mm_s, recording.velocity_mm_s[0]);
        errors += quiet.deviation_mm_s.powi(2);
        stated += 2.0 * (0.0005 * 500.0_f64).powi(2);
    }
    let ratio = (errors / stated).sqrt();
    assert!((ratio - 1.0).abs() < 0.2, "{ratio}");
}

/// A fast motion without noise is not taken for noise.
#[test]
fn fast_motion_is_no_noise() {
    let time_s: Vec<f64> = (0..500).map(|k| f64::from(k) / 250.0).collect();
    let rate = 2.0 * PI * 6.0;
    let mut recording = Recording::at_rest("sine", time_s.clone(), [412.0; 2]);
    recording.displacement_mm = time_s.iter().map(|t| 0.5 * (rate * t).sin()).collect();
    recording.velocity_mm_s = time_s.iter().map(|t| 0.5 * rate * (rate * t).cos()).collect();
    let start = StartVelocity::of(&recording, 0.0);
    assert_eq!(start.mm_s, recording.velocity_mm_s[0]);
    assert!(start.deviation_mm_s < 0.2, "{}", start.deviation_mm_s);
}
