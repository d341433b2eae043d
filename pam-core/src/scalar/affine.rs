//! Dense layers of plain floats with the vector instructions that the machine has.
//!
//! The weight matrix lies column by column, so one input scales one contiguous column and the
//! outputs accumulate in registers: eight vectors of outputs at a time hide the latency of the
//! fused multiply-add. A layer with one output is a dot product and is summed as one. The instruction
//! set is chosen at run time.

use crate::simd::{Float, arch};
use pulp::{Simd, WithSimd};

const BLOCK: usize = 8;

/// `out = bias + Σ_i input[i] · columns[i]`.
pub(super) fn affine<T: Float>(columns: &[T], bias: &[T], input: &[T], out: &mut [T]) {
    assert_eq!(columns.len(), input.len() * out.len(), "weights do not fit the layer");
    assert_eq!(bias.len(), out.len(), "bias does not fit the layer");
    arch().dispatch(Affine { columns, bias, input, out });
}

struct Affine<'a, T> {
    columns: &'a [T],
    bias: &'a [T],
    input: &'a [T],
    out: &'a mut [T],
}

impl<T: Float> Affine<'_, T> {
    /// `W` vectors of outputs that begin at output `first`.
    #[inline(always)]
    fn block<S: Simd, const W: usize>(&mut self, simd: S, first: usize) {
        let n = self.out.len();
        let width = W * T::lanes::<S>();
        let mut sums: [T::Vector<S>; W] = {
            let (bias, _) = T::split::<S>(&self.bias[first..first + width]);
            std::array::from_fn(|k| bias[k])
        };
        for (i, &x) in self.input.iter().enumerate() {
            let x = T::splat(simd, x);
            let start = i * n + first;
            let (column, _) = T::split::<S>(&self.columns[start..start + width]);
            let column: &[T::Vector<S>; W] = column.try_into().expect("a block is W vectors wide");
            for k in 0..W {
                sums[k] = T::fused(simd, column[k], x, sums[k]);
            }
        }
        let (out, _) = T::split_mut::<S>(&mut self.out[first..first + width]);
        out.copy_from_slice(&sums);
    }

    /// The outputs from `first` on that do not fill a vector.
    #[inline(always)]
    fn rest<S: Simd>(&mut self, simd: S, first: usize) {
        let n = self.out.len();
        let mut sum = T::load_part(simd, &self.bias[first..]);
        for (column, &x) in self.columns.chunks_exact(n).zip(self.input) {
            sum = T::fused(simd, T::load_part(simd, &column[first..]), T::splat(simd, x), sum);
        }
        T::store_part(simd, &mut self.out[first..], sum);
    }

    /// `Σ columns_i · input_i` for one output, in four running sums.
    #[inline(always)]
    fn dot<S: Simd>(&self, simd: S) -> T {
        let (w, w_rest) = T::split::<S>(self.columns);
        let (x, x_rest) = T::split::<S>(self.input);
        let mut sums = [T::splat(simd, T::default()); 4];
        let mut w_quads = w.chunks_exact(4);
        let mut x_quads = x.chunks_exact(4);
        for (w, x) in (&mut w_quads).zip(&mut x_quads) {
            for k in 0..4 {
                sums[k] = T::fused(simd, w[k], x[k], sums[k]);
            }
        }
        for (&w, &x) in w_quads.remainder().iter().zip(x_quads.remainder()) {
            sums[0] = T::fused(simd, w, x, sums[0]);
        }
        let (w, x) = (T::load_part(simd, w_rest), T::load_part(simd, x_rest));
        sums[1] = T::fused(simd, w, x, sums[1]);
        let halves = (T::plus(simd, sums[0], sums[1]), T::plus(simd, sums[2], sums[3]));
        T::across(simd, T::plus(simd, halves.0, halves.1))
    }
}

impl<T: Float> WithSimd for Affine<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let n = self.out.len();
        if n == 1 {
            self.out[0] = self.bias[0] + self.dot(simd);
            return;
        }
        let lanes = T::lanes::<S>();
        let mut first = 0;
        while first + BLOCK * lanes <= n {
            self.block::<S, BLOCK>(simd, first);
            first += BLOCK * lanes;
        }
        while first + 4 * lanes <= n {
            self.block::<S, 4>(simd, first);
            first += 4 * lanes;
        }
        while first + lanes <= n {
            self.block::<S, 1>(simd, first);
            first += lanes;
        }
        if first < n {
            self.rest(simd, first);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The kernel equals the textbook sum to rounding, for every shape.
        #[test]
        fn equals_the_plain_sum(
            rows in 1_usize..140,
            cols in 0_usize..70,
            seed in 0_u32..1000,
        ) {
            let value = |k: usize| (f64::from(seed) + k as f64 * 0.7391).sin();
            let columns: Vec<f64> = (0..rows * cols).map(value).collect();
            let bias: Vec<f64> = (0..rows).map(|k| value(k + 7)).collect();
            let input: Vec<f64> = (0..cols).map(|k| value(k + 31)).collect();
            let mut out = vec![0.0; rows];
            affine(&columns, &bias, &input, &mut out);
            let columns32: Vec<f32> = columns.iter().map(|&v| v as f32).collect();
            let bias32: Vec<f32> = bias.iter().map(|&v| v as f32).collect();
            let input32: Vec<f32> = input.iter().map(|&v| v as f32).collect();
            let mut out32 = vec![0.0_f32; rows];
            affine(&columns32, &bias32, &input32, &mut out32);
            for j in 0..rows {
                let expected: f64 =
                    bias[j] + (0..cols).map(|i| columns[i * rows + j] * input[i]).sum::<f64>();
                prop_assert!((out[j] - expected).abs() < 1e-12);
                prop_assert!((f64::from(out32[j]) - expected).abs() < 1e-4);
            }
        }
    }
}
