//! Measures the time of the solution alone and of value and gradient on the training conditions of 70 s, and
//! how it grows with width and depth of the network and with the noise of the force.
//!
//! `cargo bench -p pam-exact --bench speed -- [RECORDINGS [CASE]]`: all cases, or those whose
//! names begin with CASE.
//!
//! CPU time is that of all threads together (Linux); other programs disturb it less than the wall time.

#[path = "../tests/all/common/mod.rs"]
mod common;

use common::limits::{problem, squares};
use common::random::{random_joint, spread};
use pam_core::NamedChoice;
use pam_exact::{ExactMotion, ExactProblem, ExactSolver};
use pam_solvers::Interpolation;
use std::time::Instant;

/// The arguments, without the one that `cargo bench` adds.
fn arguments() -> impl Iterator<Item = String> {
    std::env::args().skip(1).filter(|a| a != "--bench")
}

/// Wall time and CPU time of `run`, s.
fn clocks(run: impl FnOnce()) -> [f64; 2] {
    let (start, before) = (Instant::now(), cpu_s());
    run();
    [start.elapsed().as_secs_f64(), cpu_s() - before]
}

/// CPU time of this process so far, from the kernel's accounts of its threads, s.
fn cpu_s() -> f64 {
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else { return f64::NAN };
    let of = |thread: std::fs::DirEntry| -> Option<f64> {
        let account = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        account.split_whitespace().next()?.parse().ok()
    };
    threads.flatten().filter_map(of).sum::<f64>() * 1e-9
}

/// Prints the times for `count` recordings.
fn time(
    name: &str,
    motion: &ExactMotion,
    (times, force): (&[f64], &[f64]),
    interpolation: Interpolation,
    count: usize,
) {
    if !name.starts_with(&arguments().nth(1).unwrap_or_default()) {
        return;
    }
    let problems: Vec<ExactProblem<'_>> = common::masses(count)
        .into_iter()
        .map(|masses| problem(times, force, interpolation, masses))
        .collect();
    let mut solver = ExactSolver::new();
    let mut result = None;
    let mut best = [[f64::INFINITY; 2]; 2];
    for _ in 0..7 {
        let least = |best: [f64; 2], run: [f64; 2]| [best[0].min(run[0]), best[1].min(run[1])];
        best[0] = least(best[0], clocks(|| drop(solver.solve(motion, &problems))));
        let gradient = || result = Some(solver.value_and_gradient(motion, &problems, &squares));
        best[1] = least(best[1], clocks(gradient));
    }
    let result = result.expect("there was a round");
    let of = count as f64;
    println!(
        "| {name} | {} | {count} | {:.3} | {:.3} | {:.3} | {:.3} | {:.0} | {:.0} | {:.0} | {} |",
        interpolation.name(),
        best[0][0],
        best[0][1],
        best[1][0],
        best[1][1],
        result.statistics.segments as f64 / of,
        result.statistics.crossings as f64 / of,
        result.statistics.regions as f64 / of,
        result.failures.len()
    );
}

fn main() {
    let count = arguments().next().and_then(|a| a.parse().ok()).unwrap_or(29);
    let motion = common::motion(&common::perturbed());
    let (times, force) = common::excitation(0.0, 70_000);
    println!(
        "| case | force | recordings | forward, s | CPU, s | value and gradient, s | CPU, s \
         | segments | crossings | regions | failed |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for interpolation in [Interpolation::Hold, Interpolation::Linear, Interpolation::Ramp] {
        time("published size", &motion, (&times, &force), interpolation, count);
    }
    for noise_a in [0.01, 0.05, 0.2] {
        let mut next = spread();
        let per_a = pam_core::units::tendon_force_mn_per_a();
        let noisy: Vec<f64> = force.iter().map(|f| f + noise_a * per_a * next()).collect();
        let name = format!("noise {noise_a} A");
        time(&name, &motion, (&times, &noisy), Interpolation::Hold, count.min(4));
    }
    let activation = *common::published().force.mlp().activation();
    for (width, hidden) in [(32, 2), (96, 1), (96, 2), (96, 3), (192, 2), (384, 2)] {
        let motion = common::motion(&random_joint(&vec![width; hidden], activation));
        let name = format!("random {hidden} × {width}");
        time(&name, &motion, (&times, &force), Interpolation::Hold, count.min(4));
    }
}
