use super::ActivationFunction;
use crate::scalar::Scalar;
use serde::{Deserialize, Serialize};

/// `max(z, 0)`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Relu;

impl ActivationFunction for Relu {
    const PIECEWISE_LINEAR: bool = true;

    #[inline]
    fn value<S: Scalar>(&self, z: S) -> S {
        if z.real() > 0.0 { z } else { S::zero() }
    }
}
