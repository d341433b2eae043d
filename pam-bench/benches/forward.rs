//! Forward simulation of a 70 s recording with the published 96×96 network, on one thread.

use criterion::{Criterion, criterion_group, criterion_main};
use pam_bench::{published_model, recording};
use pam_solvers::{Interpolation, Tableau};
use pam_trajectory::{SolverSettings, StepChoice, predict};
use std::hint::black_box;

fn forward(criterion: &mut Criterion) {
    let model = published_model();
    let (clean, masses) = recording(&model, 0.0);
    let (noisy, _) = recording(&model, 0.05);
    let settings = |tableau, step, interpolation| SolverSettings { tableau, step, interpolation };
    let constant = |ms: f64| StepChoice::Constant { step_s: ms * 1e-3 };
    let adaptive = StepChoice::Adaptive { rtol: 1e-6, atol: 1e-6 };
    let cases = [
        ("tsit5 1 ms held", settings(Tableau::tsit5(), constant(1.0), Interpolation::Hold)),
        ("tsit5 adaptive 1e-6 held", settings(Tableau::tsit5(), adaptive, Interpolation::Hold)),
        ("tsit5 adaptive 1e-6 linear", settings(Tableau::tsit5(), adaptive, Interpolation::Linear)),
        (
            "dp5 adaptive 1e-6 linear",
            settings(Tableau::dormand_prince5(), adaptive, Interpolation::Linear),
        ),
        ("rk4 5 ms linear", settings(Tableau::rk4(), constant(5.0), Interpolation::Linear)),
    ];
    let mut group = criterion.benchmark_group("forward 70 s");
    group.sample_size(10);
    for (force, recording) in [("clean force", &clean), ("noisy force", &noisy)] {
        for (name, settings) in &cases {
            group.bench_function(format!("{name}, {force}"), |b| {
                b.iter(|| {
                    predict(black_box(&model), recording, masses, settings).expect("it runs")
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, forward);
criterion_main!(benches);
