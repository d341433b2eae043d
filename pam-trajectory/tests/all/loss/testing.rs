//! Random recordings, and the check of cotangents.

use pam_data::{Channel, Recording};
use pam_trajectory::TrajectoryLoss;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::path::Path;

/// Samples 0.01 s apart from 7.3 s on, each channel drawn from a box.
pub(crate) fn random_recording(samples: usize, seed: u64) -> Recording {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut column = |low: f64, high: f64| -> Vec<f64> {
        (0..samples).map(|_| random.random_range(low..high)).collect()
    };
    Recording {
        displacement_mm: column(-3.0, 3.0),
        velocity_mm_s: column(-20.0, 20.0),
        pressure_flexor_kpa: column(150.0, 250.0),
        pressure_extensor_kpa: column(150.0, 250.0),
        force_mn: vec![0.0; samples],
        time_s: (0..samples).map(|k| 7.3 + 0.01 * k as f64).collect(),
        ..Recording::empty(Path::new("random"))
    }
}

/// The same state in every sample.
pub(crate) fn constant_recording(samples: usize, state: [f64; 4]) -> Recording {
    let [x, v, pf, pe] = state.map(|value| vec![value; samples]);
    Recording {
        displacement_mm: x,
        velocity_mm_s: v,
        pressure_flexor_kpa: pf,
        pressure_extensor_kpa: pe,
        ..random_recording(samples, 0)
    }
}

/// The states of a recording with errors of up to three units.
pub(crate) fn noisy(measured: &Recording, seed: u64) -> Vec<[f64; 4]> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..measured.len())
        .map(|k| Channel::ALL.map(|c| measured.channel(c)[k] + random.random_range(-3.0..3.0)))
        .collect()
}

/// Compares cotangents with central differences of the value, on random data.
pub(crate) fn assert_cotangents(loss: &dyn TrajectoryLoss, seed: u64) {
    const SAMPLES: usize = 23;
    const H: f64 = 1e-4;
    let measured = random_recording(SAMPLES, seed);
    let mut predicted = noisy(&measured, seed + 1000);
    let mut unused = vec![[0.0; 4]; SAMPLES];
    // A loss writes its cotangents; it does not add to what is there.
    let mut cotangents = vec![[f64::NAN; 4]; SAMPLES];
    loss.value_and_cotangents(&measured, &predicted, &mut cotangents);
    let largest = cotangents.as_flattened().iter().fold(0.0_f64, |a, c| a.max(c.abs()));
    assert!(largest > 0.0);
    for k in 0..SAMPLES {
        for i in 0..4 {
            let middle = predicted[k][i];
            let mut at = |value: f64| {
                predicted[k][i] = value;
                loss.value_and_cotangents(&measured, &predicted, &mut unused)
            };
            let slope = (at(middle + H) - at(middle - H)) / (2.0 * H);
            predicted[k][i] = middle;
            let found = cotangents[k][i];
            assert!((slope - found).abs() < 1e-6 * largest, "sample {k}: {slope} and {found}");
        }
    }
}
