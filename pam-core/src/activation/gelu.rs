use super::{ActivationFunction, Tanh};
use crate::scalar::Scalar;
use serde::{Deserialize, Serialize};

/// `½ z (1 + tanh(√(2/π) (z + 0.044715 z³)))`, the tanh form of `z Φ(z)`
/// (Hendrycks and Gimpel 2016). JAX and PyTorch (`approximate="tanh"`) compute the same.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Gelu;

impl ActivationFunction for Gelu {
    #[inline]
    fn value<S: Scalar>(&self, z: S) -> S {
        let inner = (z + (z * z * z).scaled(0.044_715))
            .scaled(std::f64::consts::FRAC_2_SQRT_PI * std::f64::consts::FRAC_1_SQRT_2);
        z.scaled(0.5) * (S::constant(1.0) + Tanh.value(inner))
    }
}
