//! Squared weights.

use super::Regulariser;
use pam_core::settings::{SettingsError, require_weights};
use pam_trajectory::engine::NetworkJoint;
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
