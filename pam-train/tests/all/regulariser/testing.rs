//! Random joints, and the check of gradients.

use pam_core::force::Dense;
use pam_core::{Activation, JointModel, Mlp, NetworkForce, ParametricForce};
use pam_train::Regulariser;
use pam_trajectory::engine::NetworkJoint;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// A joint whose force is a network of `layers` with tanh.
pub(crate) fn joint(layers: Vec<Dense<f64>>) -> NetworkJoint {
    let mlp = Mlp::new(layers, Activation::from_name("tanh").unwrap()).unwrap();
    JointModel::datasheet(NetworkForce::new(mlp).unwrap())
}

/// The same with random weights.
pub(crate) fn random_joint(widths: &[usize], seed: u64) -> NetworkJoint {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut numbers = |n: usize| (0..n).map(|_| random.random_range(-0.8..0.8)).collect::<Vec<_>>();
    let layers =
        widths.windows(2).map(|w| Dense::from_rows(&numbers(w[0] * w[1]), numbers(w[1])).unwrap());
    joint(layers.collect())
}

/// Compares the gradient with central differences, and sees that it is added.
pub(crate) fn assert_gradient(regulariser: &dyn Regulariser, model: &NetworkJoint) {
    let weights = model.force.parameters();
    let mut gradient = vec![0.5; weights.len()];
    let value = regulariser.value_and_gradient(model, &mut gradient);
    assert!(value > 0.0, "nothing is penalised");
    let mut unused = vec![0.0; weights.len()];
    let largest = gradient.iter().fold(0.0_f64, |a, g| a.max((g - 0.5).abs()));
    for i in 0..weights.len() {
        let mut at = |h: f64| {
            let mut shifted = weights.clone();
            shifted[i] += h;
            let mut other = model.clone();
            other.force = model.force.with_parameters(&shifted);
            regulariser.value_and_gradient(&other, &mut unused)
        };
        let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
        let found = gradient[i] - 0.5;
        assert!((slope - found).abs() < 1e-6 * largest, "weight {i}: {slope} and {found}");
    }
}
