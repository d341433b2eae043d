//! The loops of the layer's sweeps, with the vector instructions of the machine.

use super::Element;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// `Σ a_k b_k` in sixteen running sums, which the compiler keeps in vectors.
#[inline(always)]
fn dot<T: Element>(a: &[T], b: &[T]) -> T {
    const SUMS: usize = 16;
    let mut sums = [T::zero(); SUMS];
    let (a_whole, b_whole) = (a.chunks_exact(SUMS), b.chunks_exact(SUMS));
    let mut rest = T::zero();
    for (&x, &y) in a_whole.remainder().iter().zip(b_whole.remainder()) {
        rest += x * y;
    }
    for (x, y) in a_whole.zip(b_whole) {
        for k in 0..SUMS {
            sums[k] += x[k] * y[k];
        }
    }
    sums.into_iter().fold(rest, |sum, part| sum + part)
}

#[inline(always)]
fn add_scaled<T: Element>(out: &mut [T], factor: T, column: &[T]) {
    for (o, &c) in out.iter_mut().zip(column) {
        *o += factor * c;
    }
}

/// `out_i += columns_i · w` for every column.
pub(super) fn add_dots<T: Element>(out: &mut [T], columns: &[T], w: &[T]) {
    struct Kernel<'a, T>(&'a mut [T], &'a [T], &'a [T]);
    impl<T: Element> WithSimd for Kernel<'_, T> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, _simd: S) {
            let Self(out, columns, w) = self;
            for (o, column) in out.iter_mut().zip(columns.chunks_exact(w.len())) {
                *o += dot(column, w);
            }
        }
    }
    arch().dispatch(Kernel(out, columns, w));
}

/// `columns_i += factors_i w` for every column: an outer product.
pub(super) fn add_outer<T: Element>(columns: &mut [T], factors: &[T], w: &[T]) {
    struct Kernel<'a, T>(&'a mut [T], &'a [T], &'a [T]);
    impl<T: Element> WithSimd for Kernel<'_, T> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, _simd: S) {
            let Self(columns, factors, w) = self;
            for (column, &factor) in columns.chunks_exact_mut(w.len()).zip(factors) {
                if !factor.vanishes() {
                    add_scaled(column, factor, w);
                }
            }
        }
    }
    arch().dispatch(Kernel(columns, factors, w));
}

/// `out += Σ_i factors_i columns_i`.
pub(super) fn add_columns<T: Element>(out: &mut [T], factors: &[T], columns: &[T]) {
    struct Kernel<'a, T>(&'a mut [T], &'a [T], &'a [T]);
    impl<T: Element> WithSimd for Kernel<'_, T> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, _simd: S) {
            let Self(out, factors, columns) = self;
            for (column, &factor) in columns.chunks_exact(out.len()).zip(factors) {
                if !factor.vanishes() {
                    add_scaled(out, factor, column);
                }
            }
        }
    }
    arch().dispatch(Kernel(out, factors, columns));
}
