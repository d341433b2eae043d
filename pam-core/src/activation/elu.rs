use super::ActivationFunction;
use crate::scalar::Scalar;
use crate::simd::{Float, math};
use serde::{Deserialize, Serialize};

/// `z` for positive `z`, `eᶻ − 1` otherwise (Clevert, Unterthiner and Hochreiter 2016).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Elu;

impl ActivationFunction for Elu {
    #[inline]
    fn value<S: Scalar>(&self, z: S) -> S {
        if z.real() > 0.0 { z } else { z.exp_m1() }
    }

    #[inline(always)]
    fn value_and_slope<T: Float>(&self, z: T) -> (T, T) {
        let (e_m1, e) = math::exp_m1_and_exp(z);
        if z > T::narrow(0.0) { (z, T::narrow(1.0)) } else { (e_m1, e) }
    }
}
