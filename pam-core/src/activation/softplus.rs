use super::ActivationFunction;
use crate::scalar::Scalar;
use serde::{Deserialize, Serialize};

/// `ln(1 + eᶻ)`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Softplus;

impl ActivationFunction for Softplus {
    #[inline]
    fn value<S: Scalar>(&self, z: S) -> S {
        z.softplus()
    }
}
