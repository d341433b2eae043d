use super::ActivationFunction;
use crate::scalar::Scalar;
use crate::simd::{Float, math};
use serde::{Deserialize, Serialize};

/// `z / (1 + e⁻ᶻ)`, also called swish (Elfwing, Uchibe and Doya 2018).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Silu;

impl ActivationFunction for Silu {
    #[inline]
    fn value<S: Scalar>(&self, z: S) -> S {
        z * z.sigmoid()
    }

    #[inline(always)]
    fn value_and_slope<T: Float>(&self, z: T) -> (T, T) {
        let s = math::sigmoid(z);
        (z * s, s + z * s * math::sigmoid(-z))
    }
}
