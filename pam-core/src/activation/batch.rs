//! Activations over whole slices, compiled for each instruction set.

use super::ActivationFunction;
use crate::simd::{Float, arch};
use pulp::{Simd, WithSimd};

struct Values<'a, A, T> {
    activation: &'a A,
    z: &'a mut [T],
}

impl<A: ActivationFunction, T: Float> WithSimd for Values<'_, A, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for z in self.z {
            *z = self.activation.value_and_slope(*z).0;
        }
    }
}

struct ValuesAndSlopes<'a, A, T> {
    activation: &'a A,
    z: &'a mut [T],
    slopes: &'a mut [T],
}

impl<A: ActivationFunction, T: Float> WithSimd for ValuesAndSlopes<'_, A, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for (z, slope) in self.z.iter_mut().zip(self.slopes) {
            (*z, *slope) = self.activation.value_and_slope(*z);
        }
    }
}

pub(super) fn values<A: ActivationFunction, T: Float>(activation: &A, z: &mut [T]) {
    arch().dispatch(Values { activation, z });
}

pub(super) fn values_and_slopes<A: ActivationFunction, T: Float>(
    activation: &A,
    z: &mut [T],
    slopes: &mut [T],
) {
    assert_eq!(z.len(), slopes.len(), "one slope for each value");
    arch().dispatch(ValuesAndSlopes { activation, z, slopes });
}
