//! Time of effects as expressions over that of the same effects in Rust: one simulation of 20 s, and its derivatives by the
//! parameters.
//!
//! `cargo bench -p pam-effects --bench expression_speed`

use pam_core::{AnyForce, JointModel, Scalar, SpringDamper};
use pam_data::{Recording, subjects};
use pam_effects::effects::{AnyEffect, Derivatives, by_id};
use pam_effects::expression;
use pam_effects::simulation::{Base, Nuisances, SimulationScalar, Trajectory, Trial, simulate};
use std::f64::consts::TAU;
use std::time::Instant;

/// Built-in effects with values at which they are there.
const EFFECTS: [(&str, &[f64]); 8] = [
    ("viscous_damping", &[800.0]),
    ("cogging", &[7.0, 0.613]),
    ("creep", &[8.0, 0.7]),
    ("stribeck_friction", &[9.0, 17.0, 2.1]),
    ("load_friction", &[0.041]),
    ("leak", &[1.5e-3, 7e-4]),
    ("actuator_lag", &[4.3]),
    ("position_sensor_lag", &[6.0]),
];
const REPEATS: usize = 41;

/// Seconds of two ways to do the same, by turns: the shortest, which other programs disturb least, and their ratio.
fn compared(mut ways: [&mut dyn FnMut(); 2]) -> [f64; 3] {
    let mut shortest = [f64::INFINITY; 2];
    for _ in 0..REPEATS {
        for (way, shortest) in ways.iter_mut().zip(&mut shortest) {
            let start = Instant::now();
            way();
            *shortest = shortest.min(start.elapsed().as_secs_f64());
        }
    }
    [shortest[0], shortest[1], shortest[1] / shortest[0]]
}

fn run<S: SimulationScalar>(
    trial: &Trial,
    base: &Base<f64>,
    effect: &dyn AnyEffect,
    values: &[S],
    out: &mut Trajectory<S>,
) {
    simulate::<S>(trial, base, &[effect], values, &Nuisances::none(), out).expect("in range");
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let joint = JointModel::datasheet(AnyForce::from(SpringDamper::published()));
    let time_s: Vec<f64> = (0..5000).map(|k| 4e-3 * f64::from(k)).collect();
    let command = Recording::at_rest("made up", time_s, [412.0, 412.0])
        .with_force(|t| 1.5e5 * (TAU * t).sin());
    let subject = subjects(vec![command], &joint)?.remove(0);
    let (trial, base) = (Trial::new(&joint, &subject), Base::of(&joint));
    let same = expression::parse(include_str!("../tests/effects/built_in.toml"))?;
    println!("effect                  plain: Rust   expression  ratio  derivatives: Rust   ratio");
    let (mut least, mut worst) = (f64::INFINITY, 0.0_f64);
    // A memory of one exponential has a closed form in Rust.
    let mut worst_with_memory = 0.0_f64;
    for (id, values) in EFFECTS {
        let built_in = by_id(id).ok_or("a built-in effect")?;
        let own = same.iter().find(|e| e.info().id.strip_prefix("x_") == Some(id));
        let own = *own.ok_or("the same as an expression")?;
        let mut out = Trajectory::default();
        let mut other = Trajectory::default();
        let plain = compared([&mut || run(&trial, &base, built_in, values, &mut out), &mut || {
            run(&trial, &base, own, values, &mut other)
        }]);
        let seeded: Vec<Derivatives> =
            values.iter().enumerate().map(|(k, v)| Derivatives::variable(*v, k)).collect();
        let mut out = Trajectory::<Derivatives>::default();
        let mut other = Trajectory::<Derivatives>::default();
        let with = compared([&mut || run(&trial, &base, built_in, &seeded, &mut out), &mut || {
            run(&trial, &base, own, &seeded, &mut other)
        }]);
        println!(
            "{id:<22} {:>9.2} ms {:>9.2} ms {:>6.2} {:>15.2} ms {:>7.2}",
            1e3 * plain[0],
            1e3 * plain[1],
            plain[2],
            1e3 * with[0],
            with[2]
        );
        least = least.min(plain[2]).min(with[2]);
        if built_in.memory_len() > 0 {
            worst_with_memory = worst_with_memory.max(plain[2]).max(with[2]);
        } else {
            worst = worst.max(plain[2]).max(with[2]);
        }
        let near = |a: &f64, b: &Derivatives| (a - b.real()).abs() < 1e-8;
        assert!(plain.iter().all(|t| *t > 0.0));
        let [x, ..] = &other.channels;
        let mut own_plain = Trajectory::default();
        run(&trial, &base, own, values, &mut own_plain);
        assert!(own_plain.channels[0].iter().zip(x).all(|(a, b)| near(a, b)));
    }
    println!("smallest ratio: {least:.2}");
    println!("largest ratio: {worst:.2}");
    println!("largest ratio with memory: {worst_with_memory:.2}");
    Ok(())
}
