//! The force table beyond the motion for which it was made.

use crate::support::published::{exact_run, weights};
use pam_autodiff::numbers::Chunk;
use pam_effects::simulation::{Base, ForceTable, Nuisances, Trajectory, Trial, simulate};

const PSI: [f64; 2] = [30.0, 60.0];

/// A table, and the displacements and velocities at its edges.
fn table() -> (ForceTable, [[f64; 2]; 2]) {
    let model = weights();
    let trial = Trial::new(&model, &exact_run(&model, PSI, 0.05));
    let edges = trial.record.ranges.map(|[low, high]| {
        let margin = 0.25 * (high - low) + 0.5;
        [low - margin, high + margin]
    });
    (trial.table, edges)
}

/// Ten points across, or beyond, a range.
fn across([low, high]: [f64; 2], beyond: f64) -> Vec<f64> {
    let wider = beyond * (high - low);
    (0..10).map(|k| low - wider + (high - low + 2.0 * wider) * f64::from(k) / 9.0).collect()
}

/// The network's own force may fall outside its data. That of the table rises by its mean stiffness there, and with the velocity by its
/// mean damping.
#[test]
fn beyond_the_table_the_joint_stays_stiff_and_damped() {
    let (table, [x, v]) = table();
    let force = |x: f64, v: f64| table.force_mn(x, v, [0.0; 2]);
    let mean = |slopes: Vec<f64>| slopes.iter().sum::<f64>() / slopes.len() as f64;
    let along_x = |&v: &f64| (force(x[1], v) - force(x[0], v)) / (x[1] - x[0]);
    let along_v = |&x: &f64| (force(x, v[1]) - force(x, v[0])) / (v[1] - v[0]);
    let stiffness = mean(across(v, 0.0).iter().map(along_x).collect());
    let damping = mean(across(x, 0.0).iter().map(along_v).collect());
    for &v in &across(v, 3.0) {
        for [inner, outer] in [[x[1], x[1] + 20.0], [x[0] - 20.0, x[0]]] {
            let slope = (force(outer, v) - force(inner, v)) / (outer - inner);
            assert!((slope / stiffness - 1.0).abs() < 0.02, "{slope} and {stiffness} at {v} mm/s");
        }
    }
    for &x in &across(x, 3.0) {
        for [slower, faster] in [[v[1], v[1] + 50.0], [v[0] - 50.0, v[0]]] {
            let slope = (force(x, faster) - force(x, slower)) / 50.0;
            assert!((slope / damping - 1.0).abs() < 0.05, "{slope} and {damping} at {x} mm");
        }
    }
}

/// Across the edges the force is continuous, and on either side its derivatives are those of its values.
#[test]
fn the_force_goes_on_across_the_edges() {
    let (table, [x, v]) = table();
    let change_g = [1e-3, -2e-3];
    let force = |x: f64, v: f64| table.force_mn(x, v, change_g);
    for x_at in across(x, 0.6) {
        for v_at in across(v, 0.6) {
            let variable = |value: f64, k: usize| Chunk::<2, f64>::variable(value, k);
            let constant = change_g.map(|g| Chunk::<2, f64>::new(g, [0.0; 2]));
            let dual = table.force_mn(variable(x_at, 0), variable(v_at, 1), constant);
            assert_eq!(dual.value, force(x_at, v_at));
            let h = 1e-6;
            let by_x = (force(x_at + h, v_at) - force(x_at - h, v_at)) / (2.0 * h);
            let by_v = (force(x_at, v_at + h) - force(x_at, v_at - h)) / (2.0 * h);
            for (k, difference) in [by_x, by_v].into_iter().enumerate() {
                let slope = dual.derivatives[k];
                let size = slope.abs().max(1.0);
                assert!((slope - difference).abs() < 1e-3 * size, "{slope} and {difference}");
            }
        }
    }
    for v_at in across(v, 0.6) {
        for edge in x {
            let jump = force(edge + 1e-9, v_at) - force(edge - 1e-9, v_at);
            assert!(jump.abs() < 0.01, "{jump} mN at {edge} mm");
        }
    }
}

/// A recorded force that is far larger than the one that acted drives the model where it has no data; its simulation stays finite.
#[test]
fn a_force_that_never_acted_does_not_let_the_simulation_run_away() {
    let model = weights();
    let mut run = exact_run(&model, PSI, 0.05);
    run.recording.force_mn.iter_mut().for_each(|f| *f *= 10.0);
    let trial = Trial::new(&model, &run);
    let mut out = Trajectory::default();
    simulate::<f64>(&trial, &Base::of(&model), &[], &[], &Nuisances::none(), &mut out)
        .expect("a finite motion");
    let farthest = out.channels[0].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    // 2 kN at 100 N/mm, with as much again for resonance.
    assert!((4.0..40.0).contains(&farthest), "{farthest} mm");
}
