//! Models that are off by a given amount.

use super::case::ModelError;
use crate::plant::normal;
use pam_core::{AnyForce, ForceInput, ForceModel};
use pam_data::SavedModel;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// States at which the size of a perturbation is measured.
const STATES: usize = 2000;

/// Their ranges: air (g) from about 20 to 80 psi, displacement (mm), velocity (mm/s).
const MASS_G: [f64; 2] = [0.045, 0.12];
const DISPLACEMENT_MM: f64 = 1.5;
const VELOCITY_MM_S: f64 = 10.0;

/// The model with an error.
///
/// [`ModelError::Force`] changes the weights of the last layer at random, scaled so that the force changes by the given
/// share of its own root mean square over the working range of the joint: the change is a function of all inputs, as
/// smooth as the force itself.
///
/// # Panics
/// If the force is no network.
#[must_use]
pub fn perturbed(saved: &SavedModel, error: ModelError, seed: u64) -> SavedModel {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut changed = saved.clone();
    let force = &saved.model.force;
    match error {
        ModelError::None => {}
        ModelError::Weights(relative) => {
            changed.model.force = with_tensors(force, |name, values| {
                if name.starts_with("weight") {
                    values.iter_mut().for_each(|w| *w *= 1.0 + relative);
                }
            });
        }
        ModelError::Force(relative) => {
            let last = last_layer(force);
            let drawn: Vec<f64> = (0..last.1).map(|_| normal(&mut random)).collect();
            let step = |size: f64| {
                with_tensors(force, |name, values| {
                    if name == last.0 {
                        let factors = drawn.iter().map(|d| 1.0 + size * d);
                        values.iter_mut().zip(factors).for_each(|(w, f)| *w *= f);
                    }
                })
            };
            // The force is linear in these weights, so that one trial gives the scale.
            let trial = 0.01;
            let [own, change] = sizes(force, &step(trial), &mut random);
            changed.model.force = step(trial * relative * own / change);
        }
    }
    changed
}

/// Name and length of the weights of the last layer.
fn last_layer(force: &AnyForce<f64>) -> (String, usize) {
    let parts = force.to_parts();
    let mut backwards = parts.tensors.iter().rev();
    let weights = backwards.find(|(name, _)| name.starts_with("weight"));
    let (name, tensor) = weights.expect("a network");
    (name.clone(), tensor.values.len())
}

fn with_tensors(force: &AnyForce<f64>, change: impl Fn(&str, &mut [f64])) -> AnyForce<f64> {
    let mut parts = force.to_parts();
    for (name, tensor) in &mut parts.tensors {
        change(name, &mut tensor.values);
    }
    AnyForce::from_parts(force.kind(), &parts).expect("the same shapes")
}

/// Root mean square of a force and of its difference to another, mN.
fn sizes(a: &AnyForce<f64>, b: &AnyForce<f64>, random: &mut ChaCha8Rng) -> [f64; 2] {
    let mut work = vec![0.0; a.work_len().max(b.work_len())];
    let mut sums = [0.0; 2];
    for _ in 0..STATES {
        let input = ForceInput {
            displacement_mm: random.random_range(-DISPLACEMENT_MM..DISPLACEMENT_MM),
            velocity_mm_s: random.random_range(-VELOCITY_MM_S..VELOCITY_MM_S),
            mass_flexor_g: random.random_range(MASS_G[0]..MASS_G[1]),
            mass_extensor_g: random.random_range(MASS_G[0]..MASS_G[1]),
        };
        let [f, g] = [a, b].map(|force| force.restoring_force_mn(&input, &mut work));
        sums[0] += f * f;
        sums[1] += (g - f) * (g - f);
    }
    sums.map(|s| (s / STATES as f64).sqrt())
}
