use super::ActivationFunction;
use crate::scalar::Scalar;
use serde::{Deserialize, Serialize};

/// `sin z`, for periodic features (Sitzmann et al. 2020).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Sine;

impl ActivationFunction for Sine {
    #[inline]
    fn value<S: Scalar>(&self, z: S) -> S {
        z.sin()
    }
}
