//! Time of a simulated step with effects, plain and with derivatives.
//!
//! `cargo bench -p pam-effects --bench simulation_speed`

use pam_core::{AnyForce, JointModel, Scalar, SpringDamper};
use pam_data::{Recording, subjects};
use pam_effects::effects::{AnyEffect, Derivatives, FewDerivatives, by_id};
use pam_effects::simulation::{Base, Nuisances, SimulationScalar, Trajectory, Trial, simulate};
use std::f64::consts::TAU;
use std::time::Instant;

/// Effects with values at which they are there.
const EFFECTS: [&[(&str, &[f64])]; 9] = [
    &[],
    &[("viscous_damping", &[800.0])],
    &[("coulomb_friction", &[20.0])],
    &[("load_friction", &[0.1])],
    &[("coulomb_friction", &[20.0]), ("creep", &[8.0, 0.7])],
    &[("coulomb_friction", &[20.0]), ("force_gain", &[0.01])],
    &[("leak", &[1.5e-3, 7e-4])],
    &[("hysteresis", &[9.0, 1.0, 0.0])],
    &[("polytropic_gas", &[1.1, 1.0])],
];
const REPEATS: usize = 15;

/// Nanoseconds of a step: the shortest run, which other programs disturb least.
fn step_ns<S: SimulationScalar>(
    (trial, base): (&Trial, &Base<f64>),
    effects: &[&dyn AnyEffect],
    values: &[f64],
    variable: impl Fn(f64, usize) -> S,
) -> f64 {
    let values: Vec<S> = values.iter().enumerate().map(|(k, &v)| variable(v, k)).collect();
    let mut nuisances = Nuisances::none();
    nuisances.lead_samples = 0.1;
    nuisances.log_mass = variable(0.0, values.len());
    nuisances.log_deformation = variable(0.0, values.len() + 1);
    nuisances.start_mm = variable(0.0, values.len() + 2);
    nuisances.log_air = [variable(0.0, values.len() + 3), variable(0.0, values.len() + 4)];
    let mut out = Trajectory::default();
    let mut shortest = f64::INFINITY;
    for _ in 0..REPEATS {
        let start = Instant::now();
        simulate::<S>(trial, base, effects, &values, &nuisances, &mut out).expect("in range");
        shortest = shortest.min(start.elapsed().as_secs_f64());
    }
    1e9 * shortest / trial.record.steps() as f64
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let joint = JointModel::datasheet(AnyForce::from(SpringDamper::published()));
    let time_s: Vec<f64> = (0..5000).map(|k| 4e-3 * f64::from(k)).collect();
    let command = Recording::at_rest("made up", time_s, [412.0, 412.0])
        .with_force(|t| 1.5e5 * (TAU * t).sin());
    let subject = subjects(vec![command], &joint)?.remove(0);
    let (trial, base) = (Trial::new(&joint, &subject), Base::of(&joint));
    println!("ns per step                            plain   4 derivatives   12 derivatives");
    for of in EFFECTS {
        let effects: Vec<&dyn AnyEffect> =
            of.iter().map(|(id, _)| by_id(id).expect("built in") as &dyn AnyEffect).collect();
        let values: Vec<f64> = of.iter().flat_map(|(_, values)| values.iter().copied()).collect();
        let at = (&trial, &base);
        let plain = step_ns::<f64>(at, &effects, &values, |v, _| v);
        let few = step_ns(at, &effects, &values, |v, k| {
            if k < 4 { FewDerivatives::variable(v, k) } else { FewDerivatives::constant(v) }
        });
        let many = step_ns(at, &effects, &values, Derivatives::variable);
        let names: Vec<&str> = of.iter().map(|(id, _)| *id).collect();
        println!("{:36} {plain:7.0} {few:14.0} {many:16.0}", names.join(", "));
    }
    Ok(())
}
