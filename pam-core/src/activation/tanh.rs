use super::ActivationFunction;
use crate::scalar::Scalar;
use crate::simd::{Float, math};
use serde::{Deserialize, Serialize};

/// Hyperbolic tangent, written through `e^{−2|z|} − 1` so that derivatives stay finite far out.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Tanh;

impl ActivationFunction for Tanh {
    #[inline]
    fn value<S: Scalar>(&self, z: S) -> S {
        // e^{-2|z|} never overflows, and 1 − e keeps full precision near zero through exp_m1.
        let negative = z.real() < 0.0;
        let m = if negative { z } else { -z };
        let e1 = m.scaled(2.0).exp_m1();
        let t = -e1 / (e1 + S::constant(2.0));
        if negative { -t } else { t }
    }

    #[inline(always)]
    fn value_and_slope<T: Float>(&self, z: T) -> (T, T) {
        let t = math::tanh(z);
        (t, T::narrow(1.0) - t * t)
    }
}
