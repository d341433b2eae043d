use super::{ActivationFunction, Tanh};
use crate::scalar::Scalar;
use crate::simd::{Float, math};
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

    #[inline(always)]
    fn value_and_slope<T: Float>(&self, z: T) -> (T, T) {
        let scale = T::narrow(std::f64::consts::FRAC_2_SQRT_PI * std::f64::consts::FRAC_1_SQRT_2);
        let z2 = z * z;
        let t = math::tanh(scale * z * T::narrow(0.044_715).fma(z2, T::narrow(1.0)));
        let (half, one) = (T::narrow(0.5), T::narrow(1.0));
        let inner_slope = scale * T::narrow(3.0 * 0.044_715).fma(z2, one);
        let above = half * (one + t);
        (z * above, above + half * z * (one - t * t) * inner_slope)
    }
}
