//! Simulations of a diagnosis.

use crate::linear::{Experiment, Linear, combined, white};
use pam_diagnose::data::TestSource;
use pam_diagnose::{DiagnosisSettings, Verdict};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// A diagnosis asks for the same hypothesis many times, and simulates it once: one thread, which nothing overtakes.
#[test]
fn no_hypothesis_is_simulated_twice() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let experiments = (0..6)
        .map(|_| {
            let columns: Vec<Vec<f64>> = (0..4).map(|_| white(&mut random, 400)).collect();
            let noise = white(&mut random, 400);
            let measured = combined(&columns, &[1.0, 0.0, 0.0, 0.5], &noise, 0.3);
            let features = columns.clone();
            Experiment { columns, measured, features, ..Experiment::default() }
        })
        .collect();
    let system = Linear::new(experiments).with_offset(0.1);
    let settings = DiagnosisSettings::default();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let found = pool.install(|| system.diagnosed(TestSource::Kept, 0.3, None, &settings, 1));
    assert_eq!(found.verdict, Verdict::Explained);
    let asked = system.asked.lock().unwrap();
    assert!(asked.len() > 20, "{}", asked.len());
    let mut sorted = asked.clone();
    sorted.sort();
    let twice: Vec<&String> = sorted.windows(2).filter(|w| w[0] == w[1]).map(|w| &w[0]).collect();
    assert!(twice.is_empty(), "of {} simulations: {twice:#?}", asked.len());
}
