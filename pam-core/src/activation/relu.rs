use super::ActivationFunction;
use crate::scalar::Scalar;
use crate::simd::Float;
use serde::{Deserialize, Serialize};

/// `max(z, 0)`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Relu;

impl ActivationFunction for Relu {
    fn relu_slope(&self) -> Option<f64> {
        Some(0.0)
    }

    #[inline]
    fn value<S: Scalar>(&self, z: S) -> S {
        if z.real() > 0.0 { z } else { S::zero() }
    }

    #[inline(always)]
    fn value_and_slope<T: Float>(&self, z: T) -> (T, T) {
        let zero = T::narrow(0.0);
        if z > zero { (z, T::narrow(1.0)) } else { (zero, zero) }
    }
}
