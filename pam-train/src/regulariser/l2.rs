//! Squared weights.

use super::Regulariser;
use pam_trajectory::engine::NetworkJoint;
use pam_trajectory::settings::{SettingsError, require_weights};
use serde::{Deserialize, Serialize};

/// `strength · Σ W²` over the weight matrices of the force network, without biases (Krogh and Hertz
/// 1991).
///
/// The weights are those of the model, between unscaled inputs and a force in mN, whatever coordinates
/// an optimiser moves. Unlike the decay of [AdamW](crate::optimiser::AdamSettings) this penalty is part
/// of the loss and of its gradient.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct L2 {
    /// Factor of the sum of squares; not negative.
    pub strength: f64,
}

impl L2 {
    /// Checks that the strength is finite and not negative.
    ///
    /// # Errors
    /// [`SettingsError`] otherwise.
    pub fn check(&self) -> Result<(), SettingsError> {
        require_weights("squared weights", &[self.strength])
    }
}

impl Regulariser for L2 {
    fn value_and_gradient(&self, model: &NetworkJoint, weights_gradient: &mut [f64]) -> f64 {
        let mlp = model.force.mlp();
        assert_eq!(weights_gradient.len(), mlp.parameter_count());
        let mut rest = weights_gradient;
        let mut sum = 0.0;
        for layer in mlp.layers() {
            let weights = layer.weight_columns();
            let (by_weights, next) = rest.split_at_mut(weights.len());
            for (g, w) in by_weights.iter_mut().zip(weights) {
                sum += w * w;
                *g += 2.0 * self.strength * w;
            }
            rest = &mut next[layer.outputs()..];
        }
        self.strength * sum
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_gradient, joint, random_joint};
    use super::*;
    use pam_core::force::Dense;

    /// Weights 1, 2, 3, 4 | 5 and biases that do not count: 0.1 · 55.
    #[test]
    fn it_is_the_sum_of_squares_without_biases() {
        let model = joint(vec![
            Dense::from_rows(&[1.0, 2.0, 3.0, 4.0], vec![100.0]).unwrap(),
            Dense::from_rows(&[5.0], vec![200.0]).unwrap(),
        ]);
        let mut gradient = vec![1.0; 7];
        let value = L2 { strength: 0.1 }.value_and_gradient(&model, &mut gradient);
        assert!((value - 5.5).abs() < 1e-14);
        // Added to the ones that were there; 2 · 0.1 · w for weights, nothing for biases.
        for (found, expected) in gradient.iter().zip([1.2, 1.4, 1.6, 1.8, 1.0, 2.0, 1.0]) {
            assert!((found - expected).abs() < 1e-14, "{gradient:?}");
        }
    }

    #[test]
    fn gradient_is_the_derivative() {
        assert_gradient(&L2 { strength: 0.3 }, &random_joint(&[4, 6, 5, 1], 2));
    }
}
