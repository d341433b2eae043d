//! Dense layers of plain floats with the vector instructions that the machine has.
//!
//! The weight matrix lies column by column, so one input scales one contiguous column and the
//! outputs accumulate in registers: eight vectors of outputs at a time hide the latency of the
//! fused multiply-add. A layer with one output is a dot product and is summed as one. The instruction
//! set is chosen at run time.

use pulp::{Arch, Simd, WithSimd};
use std::sync::OnceLock;

const BLOCK: usize = 8;

fn arch() -> Arch {
    static ARCH: OnceLock<Arch> = OnceLock::new();
    *ARCH.get_or_init(Arch::new)
}

macro_rules! affine {
    ($function:ident, $kernel:ident, $float:ty, $vector:ident, $split:ident, $split_mut:ident,
     $splat:ident, $fma:ident, $add:ident, $sum:ident, $load:ident, $store:ident, $lanes:ident) => {
        pub(super) fn $function(
            columns: &[$float],
            bias: &[$float],
            input: &[$float],
            out: &mut [$float],
        ) {
            assert_eq!(columns.len(), input.len() * out.len(), "weights do not fit the layer");
            assert_eq!(bias.len(), out.len(), "bias does not fit the layer");
            arch().dispatch($kernel { columns, bias, input, out });
        }

        struct $kernel<'a> {
            columns: &'a [$float],
            bias: &'a [$float],
            input: &'a [$float],
            out: &'a mut [$float],
        }

        impl $kernel<'_> {
            /// `W` vectors of outputs that begin at output `first`.
            #[inline(always)]
            fn block<S: Simd, const W: usize>(&mut self, simd: S, first: usize) {
                let n = self.out.len();
                let width = W * S::$lanes;
                let mut acc: [S::$vector; W] = {
                    let (bias, _) = S::$split(&self.bias[first..first + width]);
                    std::array::from_fn(|k| bias[k])
                };
                for (i, &x) in self.input.iter().enumerate() {
                    let x = simd.$splat(x);
                    let start = i * n + first;
                    let (column, _) = S::$split(&self.columns[start..start + width]);
                    let column: &[S::$vector; W] =
                        column.try_into().expect("a block is W vectors wide");
                    for k in 0..W {
                        acc[k] = simd.$fma(column[k], x, acc[k]);
                    }
                }
                let (out, _) = S::$split_mut(&mut self.out[first..first + width]);
                out.copy_from_slice(&acc);
            }
        }

        impl $kernel<'_> {
            /// The outputs from `first` on that do not fill a vector.
            #[inline(always)]
            fn rest<S: Simd>(&mut self, simd: S, first: usize) {
                let n = self.out.len();
                let mut acc = simd.$load(&self.bias[first..]);
                for (column, &x) in self.columns.chunks_exact(n).zip(self.input) {
                    acc = simd.$fma(simd.$load(&column[first..]), simd.$splat(x), acc);
                }
                simd.$store(&mut self.out[first..], acc);
            }

            /// `Σ columns_i · input_i` for one output, in four running sums.
            #[inline(always)]
            fn dot<S: Simd>(&self, simd: S) -> $float {
                let (w, w_rest) = S::$split(self.columns);
                let (x, x_rest) = S::$split(self.input);
                let mut acc = [simd.$splat(0.0); 4];
                let mut w_quads = w.chunks_exact(4);
                let mut x_quads = x.chunks_exact(4);
                for (w, x) in (&mut w_quads).zip(&mut x_quads) {
                    for k in 0..4 {
                        acc[k] = simd.$fma(w[k], x[k], acc[k]);
                    }
                }
                for (&w, &x) in w_quads.remainder().iter().zip(x_quads.remainder()) {
                    acc[0] = simd.$fma(w, x, acc[0]);
                }
                acc[1] = simd.$fma(simd.$load(w_rest), simd.$load(x_rest), acc[1]);
                simd.$sum(simd.$add(simd.$add(acc[0], acc[1]), simd.$add(acc[2], acc[3])))
            }
        }

        impl WithSimd for $kernel<'_> {
            type Output = ();

            #[inline(always)]
            fn with_simd<S: Simd>(mut self, simd: S) {
                let n = self.out.len();
                if n == 1 {
                    self.out[0] = self.bias[0] + self.dot(simd);
                    return;
                }
                let mut first = 0;
                while first + BLOCK * S::$lanes <= n {
                    self.block::<S, BLOCK>(simd, first);
                    first += BLOCK * S::$lanes;
                }
                while first + 4 * S::$lanes <= n {
                    self.block::<S, 4>(simd, first);
                    first += 4 * S::$lanes;
                }
                while first + S::$lanes <= n {
                    self.block::<S, 1>(simd, first);
                    first += S::$lanes;
                }
                if first < n {
                    self.rest(simd, first);
                }
            }
        }
    };
}

affine!(
    affine_f64,
    AffineF64,
    f64,
    f64s,
    as_simd_f64s,
    as_mut_simd_f64s,
    splat_f64s,
    mul_add_e_f64s,
    add_f64s,
    reduce_sum_f64s,
    partial_load_f64s,
    partial_store_f64s,
    F64_LANES
);
affine!(
    affine_f32,
    AffineF32,
    f32,
    f32s,
    as_simd_f32s,
    as_mut_simd_f32s,
    splat_f32s,
    mul_add_e_f32s,
    add_f32s,
    reduce_sum_f32s,
    partial_load_f32s,
    partial_store_f32s,
    F32_LANES
);

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
            affine_f64(&columns, &bias, &input, &mut out);
            let columns32: Vec<f32> = columns.iter().map(|&v| v as f32).collect();
            let bias32: Vec<f32> = bias.iter().map(|&v| v as f32).collect();
            let input32: Vec<f32> = input.iter().map(|&v| v as f32).collect();
            let mut out32 = vec![0.0_f32; rows];
            affine_f32(&columns32, &bias32, &input32, &mut out32);
            for j in 0..rows {
                let expected: f64 =
                    bias[j] + (0..cols).map(|i| columns[i * rows + j] * input[i]).sum::<f64>();
                prop_assert!((out[j] - expected).abs() < 1e-12);
                prop_assert!((f64::from(out32[j]) - expected).abs() < 1e-4);
            }
        }
    }
}
