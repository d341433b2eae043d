//! Measures the time of the certified inverse synthesis along a sine.
//!
//! `cargo run --release -p pam-exact --example inverse`

#[path = "../tests/all/common/mod.rs"]
mod common;

use pam_exact::{InverseProblem, InverseSolver, Window};
use std::time::Instant;

fn main() {
    let model = common::published();
    let motion = common::motion(&model);
    let range = [0.0315, 0.1211];
    let bounds = Window { first: range, second: range };
    let mut solver = InverseSolver::default();
    let mut hint = [0.07, 0.07];
    let start = Instant::now();
    let samples = 200;
    let (mut regions, mut segments, mut pieces, mut worst) = (0, 0, 0, 0.0_f64);
    for k in 0..samples {
        let phase = std::f64::consts::TAU * f64::from(k) / f64::from(samples);
        let w = std::f64::consts::TAU * 0.1;
        let problem = InverseProblem {
            displacement_mm: phase.sin(),
            velocity_mm_s: w * phase.cos(),
            force_mn: motion.mass_kg * w * w * phase.sin(),
            stiffness_mn_mm: 150e3,
            step_mm: 1.0,
            bounds,
        };
        let solution = solver.solve(&motion.network, &problem, hint);
        hint = solution.masses_g;
        let c = solution.certificate;
        regions += c.regions;
        segments += c.segments;
        pieces += c.pieces;
        worst = worst.max(c.uncovered_share.abs());
        if k % 40 == 0 {
            println!("{solution:?}");
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    let n = f64::from(samples);
    println!(
        "{:.2} ms per sample, {:.0} regions, {:.0} segments, {:.0} pieces, uncovered at most {worst:e}",
        1e3 * seconds / n,
        regions as f64 / n,
        segments as f64 / n,
        pieces as f64 / n
    );
}
