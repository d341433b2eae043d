use super::ActivationFunction;
use crate::scalar::Scalar;
use crate::simd::{Float, math};
use serde::{Deserialize, Serialize};

/// `ln(1 + eᶻ)`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Softplus;

impl ActivationFunction for Softplus {
    #[inline]
    fn value<S: Scalar>(&self, z: S) -> S {
        z.softplus()
    }

    #[inline(always)]
    fn value_and_slope<T: Float>(&self, z: T) -> (T, T) {
        let (_, e) = math::exp_m1_and_exp(-z.magnitude());
        let positive = if z > T::narrow(0.0) { z } else { T::narrow(0.0) };
        (positive + math::ln_1p_unit(e), math::sigmoid(z))
    }
}
