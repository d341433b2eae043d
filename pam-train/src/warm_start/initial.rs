//! Networks of random weights.

use pam_core::force::Dense;
use pam_core::{Activation, Mlp, ModelError, NetworkForce};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};

/// How weights are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Initialisation {
    /// Uniform in ±√(6/inputs), biases zero (He et al. 2015).
    #[default]
    He,
    /// Weights and biases uniform in ±1/√inputs, as the published code's library does.
    InverseRoot,
}

/// Number of weights and biases of [`random_network`]; `None` if it is beyond any number.
pub(crate) fn random_network_len(hidden: &[usize]) -> Option<usize> {
    let inputs = [NetworkForce::<f64>::INPUTS].into_iter().chain(hidden.iter().copied());
    let mut outputs = hidden.iter().copied().chain([1]);
    let mut of_layers = inputs.zip(&mut outputs).map(|(n, m)| n.checked_add(1)?.checked_mul(m));
    of_layers.try_fold(0_usize, |sum, count| sum.checked_add(count?))
}

/// A force network with hidden layers of the given widths and random weights.
///
/// # Errors
/// [`ModelError::Shape`] if a width is zero.
pub fn random_network(
    hidden: &[usize],
    activation: Activation,
    initialisation: Initialisation,
    seed: u64,
) -> Result<NetworkForce<f64>, ModelError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let inputs = [NetworkForce::<f64>::INPUTS].into_iter().chain(hidden.iter().copied());
    let outputs = hidden.iter().copied().chain([1]);
    let layers = inputs.zip(outputs).map(|(n, m)| {
        let fan = n.max(1) as f64;
        let (weight, bias) = match initialisation {
            Initialisation::He => ((6.0 / fan).sqrt(), 0.0),
            Initialisation::InverseRoot => (fan.sqrt().recip(), fan.sqrt().recip()),
        };
        let mut draw = |reach: f64| reach * (2.0 * random.random::<f64>() - 1.0);
        let weights: Vec<f64> = (0..n * m).map(|_| draw(weight)).collect();
        let biases = (0..m).map(|_| draw(bias)).collect();
        Dense::from_rows(&weights, biases)
    });
    NetworkForce::new(Mlp::new(layers.collect::<Result<_, _>>()?, activation)?)
}
