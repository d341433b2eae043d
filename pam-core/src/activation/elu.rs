use super::ActivationFunction;
use crate::scalar::Scalar;
use serde::{Deserialize, Serialize};

/// `z` for positive `z`, `eᶻ − 1` otherwise (Clevert, Unterthiner and Hochreiter 2016).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Elu;

impl ActivationFunction for Elu {
    #[inline]
    fn value<S: Scalar>(&self, z: S) -> S {
        if z.real() > 0.0 { z } else { z.exp_m1() }
    }
}
