//! The hyperbolic tangent over whole batches, and its transpose.

use pam_core::simd::{Float, math};
use pulp::{Simd, WithSimd};

/// Values in place of arguments.
pub(crate) struct Tanh<'a, T> {
    pub(crate) z: &'a mut [T],
}

impl<T: Float> WithSimd for Tanh<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for z in self.z.iter_mut() {
            *z = math::tanh(*z);
        }
    }
}

/// Cotangents of the arguments from those of the values, in place.
pub(crate) struct TanhBack<'a, T> {
    pub(crate) values: &'a [T],
    pub(crate) cotangents: &'a mut [T],
}

impl<T: Float> WithSimd for TanhBack<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let one = T::narrow(1.0);
        for (c, u) in self.cotangents.iter_mut().zip(self.values) {
            *c *= one - *u * *u;
        }
    }
}
