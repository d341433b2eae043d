//! Value and gradient of the published loss on the training conditions, 70 s each, at perturbed
//! weights: seconds, and the ratio of value-and-gradient to value.
//!
//! `cargo bench -p pam-bench --bench gradient -- [RECORDINGS] [SECONDS]`

use pam_bench::{network_model, perturbed, published_model, training_set};
use pam_core::simd::Float;
use pam_data::Subject;
use pam_solvers::{Interpolation, Tableau};
use pam_trajectory::{
    BatchedEngine, SolverSettings, SquaredError, StepChoice, TrajectoryEngine, TrajectoryRequest,
    Windows,
};
use std::time::Instant;

const REPEATS: usize = 5;

/// Median time of `work`, s.
fn median(mut work: impl FnMut()) -> f64 {
    work();
    let mut times: Vec<f64> = (0..REPEATS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[REPEATS / 2]
}

fn measure<T: Float>(name: &str, settings: &SolverSettings, subjects: &[Subject]) {
    let model = network_model(&perturbed(&published_model()));
    let loss = SquaredError::published();
    let mut gradient = BatchedEngine::<T>::new(settings.clone());
    let windows = Windows::of(subjects, None);
    let request = TrajectoryRequest::new(&model, &windows);
    let value = median(|| {
        gradient.value(&request, &loss).expect("the recordings are in order");
    });
    let mut statistics = Default::default();
    let both = median(|| {
        let result = gradient.value_and_gradient(&request, &loss);
        statistics = result.expect("the recordings are in order").statistics;
    });
    println!(
        "| {name} | {} | {} | {value:.3} | {both:.3} | {:.2} | {} | {:.1} |",
        T::NAME,
        subjects.len(),
        both / value,
        statistics.evaluations,
        statistics.stored_bytes as f64 / 1e6
    );
}

fn main() {
    let numbers: Vec<f64> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let counts = numbers.first().map_or(vec![1, 3, 29], |&n| vec![n as usize]);
    let seconds = numbers.get(1).copied().unwrap_or(70.0);
    let all = training_set(&published_model(), counts[counts.len() - 1], seconds);
    let cases = [
        ("rk4 5 ms linear", Tableau::rk4(), StepChoice::Constant { step_s: 5e-3 }),
        ("rk4 10 ms linear", Tableau::rk4(), StepChoice::Constant { step_s: 10e-3 }),
        ("tsit5 1e-4 linear", Tableau::tsit5(), StepChoice::Adaptive { rtol: 1e-4, atol: 1e-4 }),
    ];
    println!(
        "| method | network | recordings | value, s | value and gradient, s | ratio | evaluations | stored, MB |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (name, tableau, step) in cases {
        let settings = SolverSettings { tableau, step, interpolation: Interpolation::Linear };
        for &count in &counts {
            measure::<f32>(name, &settings, &all[..count]);
            measure::<f64>(name, &settings, &all[..count]);
        }
    }
}
