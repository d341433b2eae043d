//! Weights and effects together: the gradient against differences of the loss itself.

use crate::support::extended::{extended, extended_by, smooth};
use crate::support::published::exact_run;
use crate::support::values::medium;
use pam_core::{AnyForce, ParametricForce};
use pam_data::MassOrigin;
use pam_data::Subject;
use pam_effects::effects::{ActivityWindow, by_id, timed};
use pam_effects::{ActiveEffect, ExtendedModel};
use pam_trajectory::{AnyLoss, Predictor, SolverSettings, TrajectoryGradient};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// A run of the model without effects, 5.6 s, behind the loader's low-pass.
fn subject(seconds_share: f64) -> Subject {
    let mut subject = exact_run(&smooth(), [30.0, 60.0], seconds_share);
    subject.recording.low_passed.cutoff_hz = [Some(20.0); 4];
    subject.origin = MassOrigin::GasLaw;
    subject
}

fn gradient(model: &ExtendedModel, subject: &Subject) -> TrajectoryGradient {
    let loss = AnyLoss::default();
    let found = model.value_and_gradient(std::slice::from_ref(subject), &loss);
    let found = found.expect("a network");
    assert!(found.failures.is_empty());
    found
}

/// The model with its weights moved by `h` along a direction that is `share` of each weight.
fn with_weights(model: &ExtendedModel, direction: &[f64], h: f64) -> ExtendedModel {
    let AnyForce::Network(force) = &model.joint.force else { panic!("a network") };
    let weights: Vec<f64> =
        force.parameters().iter().zip(direction).map(|(w, d)| w + h * d).collect();
    let mut moved = model.clone();
    moved.joint.force = AnyForce::Network(force.with_parameters(&weights));
    moved
}

/// Central differences of the loss along one number, whose error falls with the square of the change; of two
/// changes the difference tells it.
fn difference(of: impl Fn(f64) -> f64, change: f64) -> f64 {
    let at = |h: f64| (of(h) - of(-h)) / (2.0 * h);
    let (coarse, fine) = (at(2.0 * change), at(change));
    fine + (fine - coarse) / 3.0
}

/// What is trained is what is predicted: the march with the network is that with its table, up to the table's
/// interpolation.
#[test]
fn the_march_with_the_network_is_that_of_predictions() {
    let subject = subject(0.08);
    let model = extended(&[("coulomb_friction", vec![13.0]), ("pressure_sensor_lag", vec![5.0])]);
    let predicted = model
        .predict(&subject.recording, subject.masses, &SolverSettings::default())
        .expect("in range");
    let mut worst = [0.0_f64; 4];
    let seen = std::sync::Mutex::new(&mut worst);
    let compare = |_: &pam_data::Recording, states: &[[f64; 4]], by: &mut [[f64; 4]]| {
        let own = [
            &predicted.channels.x,
            &predicted.channels.v,
            &predicted.channels.pf,
            &predicted.channels.pe,
        ];
        let mut worst = seen.lock().expect("one thread");
        for (c, channel) in own.into_iter().enumerate() {
            assert_eq!(channel.len(), states.len());
            for (k, value) in channel.iter().enumerate() {
                worst[c] = worst[c].max((states[k][c] - value).abs());
            }
        }
        by.fill([0.0; 4]);
        0.0
    };
    model.value_and_gradient(std::slice::from_ref(&subject), &compare).expect("a network");
    let [x, v, pf, pe] = worst;
    assert!(x < 5e-3 && v < 0.15 && pf < 0.1 && pe < 0.1, "{worst:?}");
}

/// The same bits on one thread and on three.
#[test]
fn gradients_repeat_at_any_number_of_threads() {
    let subjects: Vec<Subject> = (0..5).map(|k| subject(0.02 + 0.005 * f64::from(k))).collect();
    let model = extended(&[("hysteresis", vec![15.0, 0.51, 0.0]), ("leak", vec![1e-3, 2e-3])]);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| model.value_and_gradient(&subjects, &AnyLoss::default()).expect("runs"))
    };
    assert_eq!(on(1), on(3));
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    #[test]
    #[ignore = "long"]
    fn the_gradient_is_that_of_the_loss_for_every_effect() {
        let subject = subject(0.05);
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut worst = 0.0_f64;
        let late = [
            ("coulomb_friction", ActivityWindow::PASSES, vec![13.0, 1.113, 2.737]),
            ("leak", ActivityWindow::BEGINS, vec![1.5e-2, 7e-3, 1.317]),
            ("added_inertia", ActivityWindow::GROWS, vec![35.0, 1.7, 1.21]),
            ("creep", ActivityWindow::BEGINS, vec![8.0, 0.7, 1.113]),
            ("pressure_sensor_lag", ActivityWindow::ENDS, vec![5.0, 2.113]),
        ];
        let of = |(id, values)| (by_id(id).expect("an id"), values);
        let always = medium().into_iter().map(of);
        let late =
            late.map(|(id, course, values)| (timed(by_id(id).expect("an id"), course), values));
        for (effect, values) in always.chain(late) {
            let id = effect.info().id;
            let extended = |values: Vec<f64>| extended_by(ActiveEffect { effect, values });
            let model = extended(values.clone());
            let found = gradient(&model, &subject);
            let AnyForce::Network(force) = &model.joint.force else { panic!("a network") };
            let direction: Vec<f64> =
                force.parameters().iter().map(|w| w * random.random_range(-1.0..1.0)).collect();
            let value = |model: &ExtendedModel| gradient(model, &subject).value;
            let mut check = |what: &str, exact: f64, by_difference: f64, size: f64| {
                let miss = (exact - by_difference).abs() / size;
                println!("{id} {what}: {exact:e} {by_difference:e} ({miss:.1e})");
                worst = worst.max(miss);
                assert!(miss < 1e-6, "{id} {what}: {exact:e}, by difference {by_difference:e}");
            };
            let parameters = effect.info().parameters;
            for (k, info) in parameters.iter().enumerate() {
                let slope = |share: f64| {
                    let moved = |h: f64| {
                        let mut moved = values.clone();
                        moved[k] += h;
                        value(&extended(moved))
                    };
                    difference(moved, share * values[k].abs())
                };
                let size = |slope: f64| slope.abs().max(1e-3 * found.value / values[k].abs());
                // A kink of a loop within the change spoils the difference: then a smaller change.
                let coarse = slope(1e-5);
                let spoiled = (coarse - found.effects[k]).abs() > 1e-6 * size(coarse);
                let slope = if spoiled { slope(1e-6) } else { coarse };
                let size = size(slope);
                check(info.name, found.effects[k], slope, size);
            }
            let along: f64 = found.force.iter().zip(&direction).map(|(g, d)| g * d).sum();
            let slope = difference(|h| value(&with_weights(&model, &direction, h)), 1e-5);
            check("weights", along, slope, slope.abs().max(1e-2 * found.value));
            let raw = [found.raw.mass, found.raw.deformation, found.raw.gas_coefficient];
            for (k, exact) in raw.into_iter().enumerate() {
                let raw = model.joint.raw;
                let change = 1e-5 * [raw.mass, raw.deformation, raw.gas_coefficient][k].abs();
                let slope = difference(
                    |h| {
                        let mut moved = model.clone();
                        let raw = &mut moved.joint.raw;
                        *[&mut raw.mass, &mut raw.deformation, &mut raw.gas_coefficient][k] += h;
                        value(&moved)
                    },
                    change,
                );
                let size = slope.abs().max(1e-3 * found.value / (1e5 * change));
                check(["m", "nu", "C"][k], exact, slope, size);
            }
        }
        println!("worst: {worst:.1e}");
    }
}
