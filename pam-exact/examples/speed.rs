//! Times value and gradient on the 29 training conditions of 70 s.
//!
//! `cargo run --release -p pam-exact --example speed -- [RECORDINGS]`

#[path = "../tests/common/mod.rs"]
mod common;

use pam_exact::{ExactProblem, ExactSolver, ForceSignal};
use pam_solvers::Interpolation;
use std::time::Instant;

fn main() {
    let count = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(29);
    let model = common::perturbed();
    let motion = common::motion(&model);
    let (times, force) = common::excitation(0.0, 70_000);
    for interpolation in [Interpolation::Hold, Interpolation::Linear, Interpolation::Ramp] {
        let signal = ForceSignal { times_s: &times, force_mn: &force, interpolation };
        let problems: Vec<ExactProblem<'_>> = common::masses(count)
            .into_iter()
            .map(|masses| ExactProblem {
                masses,
                signal,
                t0: 0.0,
                t1: times[times.len() - 1],
                y0: [0.0, 0.0],
                observe_s: &times,
            })
            .collect();
        let loss = |_: usize, states: &[f64], cotangents: &mut [f64]| {
            for (c, s) in cotangents.iter_mut().zip(states) {
                *c = 2.0 * s;
            }
            states.iter().map(|s| s * s).sum::<f64>()
        };
        let mut solver = ExactSolver::new();
        let mut best = [f64::INFINITY; 2];
        let mut result = None;
        for _ in 0..6 {
            let start = Instant::now();
            solver.value(&motion, &problems, &loss);
            best[0] = best[0].min(start.elapsed().as_secs_f64());
            let start = Instant::now();
            result = Some(solver.value_and_gradient(&motion, &problems, &loss));
            best[1] = best[1].min(start.elapsed().as_secs_f64());
        }
        let result = result.expect("there was a round");
        println!(
            "{:8} value {:.3} s, value and gradient {:.3} s; {} segments, {} crossings, {} patterns, {} failures",
            interpolation.name(),
            best[0],
            best[1],
            result.accepted,
            result.evaluations,
            result.linearised,
            result.failures.len()
        );
    }
}
