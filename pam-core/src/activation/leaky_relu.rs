use super::ActivationFunction;
use crate::scalar::Scalar;
use crate::simd::Float;
use serde::{Deserialize, Serialize};

/// `max(z, 0) + slope · min(z, 0)` (Maas, Hannun and Ng 2013).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LeakyRelu {
    /// Slope for negative arguments.
    pub slope: f64,
}

impl Default for LeakyRelu {
    fn default() -> Self {
        Self { slope: 0.01 }
    }
}

impl ActivationFunction for LeakyRelu {
    fn relu_slope(&self) -> Option<f64> {
        (0.0..=1.0).contains(&self.slope).then_some(self.slope)
    }

    #[inline]
    fn value<S: Scalar>(&self, z: S) -> S {
        if z.real() > 0.0 { z } else { z.scaled(self.slope) }
    }

    #[inline(always)]
    fn value_and_slope<T: Float>(&self, z: T) -> (T, T) {
        if z > T::narrow(0.0) {
            (z, T::narrow(1.0))
        } else {
            (z * T::narrow(self.slope), T::narrow(self.slope))
        }
    }
}
