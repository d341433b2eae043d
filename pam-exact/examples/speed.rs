//! Times the solution alone, and value and gradient, on the training conditions of 70 s, and how the time
//! grows with the width and the depth of the network and with the noise of the force.
//!
//! `cargo run --release -p pam-exact --example speed -- [RECORDINGS [CASE]]`: all cases, or those whose
//! name begins so.
//!
//! The processor time is that of all threads together (Linux), which other programs disturb less than
//! the time on the clock.

#[path = "../tests/common/mod.rs"]
mod common;

use pam_core::force::{Dense, Mlp};
use pam_core::{ActivationFunction, NetworkForce};
use pam_exact::{ExactMotion, ExactProblem, ExactSolver, ForceSignal};
use pam_solvers::Interpolation;
use std::time::Instant;

/// Evenly spread numbers in ±1, the same every time.
fn spread() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    }
}

/// A joint whose network has `hidden` layers of `width` and is a spring of about 150 N/mm with a damper
/// and random kinks.
fn random_joint(width: usize, hidden: usize) -> common::Joint {
    let mut next = spread();
    let published = common::published();
    let sizes = [0.05, 0.05, 0.7, 12.0];
    let mut layers = Vec::new();
    let first: Vec<f64> = (0..4 * width).map(|k| next() / sizes[k % 4]).collect();
    let bias = first.chunks_exact(4).map(|w| -0.08 * (w[0] + w[1]) + next()).collect::<Vec<f64>>();
    // Two units carry x and ẋ through all layers.
    let carry = |rows: &mut [f64], bias: &mut [f64], inputs: usize, from: [usize; 2]| {
        for (unit, column) in from.into_iter().enumerate() {
            rows[unit * inputs..(unit + 1) * inputs].fill(0.0);
            rows[unit * inputs + column] = 1.0;
            bias[unit] = if inputs == 4 { 1e3 } else { 0.0 };
        }
    };
    let (mut rows, mut biases) = (first, bias);
    carry(&mut rows, &mut biases, 4, [2, 3]);
    layers.push(Dense::from_rows(&rows, biases).expect("layers fit"));
    for _ in 1..hidden {
        let gain = 1.7 / (width as f64).sqrt();
        let mut rows: Vec<f64> = (0..width * width).map(|_| gain * next()).collect();
        for row in rows.chunks_exact_mut(width) {
            row[..2].fill(0.0);
        }
        let mut biases: Vec<f64> = (0..width).map(|_| 0.7 * next()).collect();
        carry(&mut rows, &mut biases, width, [0, 1]);
        layers.push(Dense::from_rows(&rows, biases).expect("layers fit"));
    }
    let mut last: Vec<f64> = (0..width).map(|_| 2e4 / (width as f64).sqrt() * next()).collect();
    last[0] = 150e3;
    last[1] = 6500.0;
    let offset = -1e3 * (last[0] + last[1]);
    layers.push(Dense::from_rows(&last, vec![offset]).expect("layers fit"));
    let activation = *published.force.mlp().activation();
    assert!(activation.rectifier_slope().is_some());
    let force =
        NetworkForce::new(Mlp::new(layers, activation).expect("layers fit")).expect("4 to 1");
    published.map(|v| v, |_| force.clone())
}

/// Seconds on the clock and of the processor that `run` takes.
fn clocks(run: impl FnOnce()) -> [f64; 2] {
    let (start, before) = (Instant::now(), processor_s());
    run();
    [start.elapsed().as_secs_f64(), processor_s() - before]
}

/// Processor time of this process so far, from the kernel's accounts of its threads, s.
fn processor_s() -> f64 {
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else { return f64::NAN };
    let of = |thread: std::fs::DirEntry| -> Option<f64> {
        let told = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        told.split_whitespace().next()?.parse().ok()
    };
    threads.flatten().filter_map(of).sum::<f64>() * 1e-9
}

/// Prints the times on `count` recordings.
fn time(
    name: &str,
    motion: &ExactMotion,
    (times, force): (&[f64], &[f64]),
    interpolation: Interpolation,
    count: usize,
) {
    if !name.starts_with(&std::env::args().nth(2).unwrap_or_default()) {
        return;
    }
    let signal = ForceSignal { times_s: times, force_mn: force, interpolation };
    let problems: Vec<ExactProblem<'_>> = common::masses(count)
        .into_iter()
        .map(|masses| ExactProblem {
            masses,
            signal,
            t0: 0.0,
            t1: times[times.len() - 1],
            y0: [0.0, 0.0],
            observe_s: times,
        })
        .collect();
    let loss = |_: usize, states: &[f64], cotangents: &mut [f64]| {
        for (c, s) in cotangents.iter_mut().zip(states) {
            *c = 2.0 * s;
        }
        states.iter().map(|s| s * s).sum::<f64>()
    };
    let mut solver = ExactSolver::new();
    let mut result = None;
    let mut best = [[f64::INFINITY; 2]; 2];
    for _ in 0..7 {
        let least = |best: [f64; 2], run: [f64; 2]| [best[0].min(run[0]), best[1].min(run[1])];
        best[0] = least(best[0], clocks(|| drop(solver.solve(motion, &problems))));
        let gradient = || result = Some(solver.value_and_gradient(motion, &problems, &loss));
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
        result.accepted as f64 / of,
        result.evaluations as f64 / of,
        result.linearised as f64 / of,
        result.failures.len()
    );
}

fn main() {
    let count = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(29);
    let motion = common::motion(&common::perturbed());
    let (times, force) = common::excitation(0.0, 70_000);
    println!(
        "| case | force | recordings | forward, s | processor, s | value and gradient, s | processor, s \
         | segments | crossings | patterns | failed |"
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
    for (width, hidden) in [(32, 2), (96, 1), (96, 2), (96, 3), (192, 2), (384, 2)] {
        let motion = common::motion(&random_joint(width, hidden));
        let name = format!("random {hidden} × {width}");
        time(&name, &motion, (&times, &force), Interpolation::Hold, count.min(4));
    }
}
