use super::arch;
use super::gemm::Product;
use crate::activation::{Activation, OwnActivation};
use crate::scalar::Scalar;
use num_dual::DualNumFloat;
use pulp::Simd;

/// A plain float with its vectors: `f32` or `f64`.
pub trait Float: Scalar<Primitive = Self> + DualNumFloat + Default + Send + Sync {
    /// A vector of the instruction set `S`.
    type Vector<S: Simd>: Copy;

    /// Name for tables and options.
    const NAME: &'static str;

    /// Numbers in a vector.
    fn lanes<S: Simd>() -> usize;

    /// Whole vectors and the rest.
    fn split<S: Simd>(slice: &[Self]) -> (&[Self::Vector<S>], &[Self]);

    /// Whole vectors and the rest.
    fn split_mut<S: Simd>(slice: &mut [Self]) -> (&mut [Self::Vector<S>], &mut [Self]);

    /// The same number in every lane.
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Vector<S>;

    /// `a b + c`, rounded once where the machine can.
    fn fused<S: Simd>(
        simd: S,
        a: Self::Vector<S>,
        b: Self::Vector<S>,
        c: Self::Vector<S>,
    ) -> Self::Vector<S>;

    /// `a + b`.
    fn plus<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;

    /// `a b`.
    fn times<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;

    /// The larger of each pair.
    fn larger<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;

    /// `x` where `gate` is positive, else `slope · x`.
    fn gated<S: Simd>(
        simd: S,
        gate: Self::Vector<S>,
        x: Self::Vector<S>,
        slope: Self::Vector<S>,
    ) -> Self::Vector<S>;

    /// The sum over the lanes.
    fn across<S: Simd>(simd: S, a: Self::Vector<S>) -> Self;

    /// A vector from the start of `slice`, zeros past its end.
    fn load_part<S: Simd>(simd: S, slice: &[Self]) -> Self::Vector<S>;

    /// Writes the first lanes of a vector to all of `slice`.
    fn store_part<S: Simd>(simd: S, slice: &mut [Self], value: Self::Vector<S>);

    /// `value` rounded to this float.
    fn narrow(value: f64) -> Self;

    /// `self` as a double.
    fn widen(self) -> f64;

    /// `self · a + b`, rounded once where the machine can.
    fn fma(self, a: Self, b: Self) -> Self;

    /// Runs a matrix product. Like the next two functions, it is compiled in this crate once for each float type.
    fn run_product(product: Product<'_, Self>);

    /// Replaces each `z` by `σ(z)`.
    fn activate(activation: &Activation, z: &mut [Self]);

    /// Replaces each `z` by `σ(z)` and writes `σ'(z)` to `slopes`.
    fn activate_with_slopes(activation: &Activation, z: &mut [Self], slopes: &mut [Self]);

    /// [`activate`](Self::activate) for an activation of another crate.
    fn activate_own(activation: &OwnActivation, z: &mut [Self]);

    /// [`activate_with_slopes`](Self::activate_with_slopes) for an activation of another crate.
    fn activate_own_with_slopes(activation: &OwnActivation, z: &mut [Self], slopes: &mut [Self]);

    /// `|self|`.
    fn magnitude(self) -> Self;

    /// Splits `x` into `n ln 2 + r` with integer `n` and `|r| ≤ ½ ln 2`; gives `r` and `2ⁿ`. `x` is
    /// first limited to where `2ⁿ` is a normal number.
    fn reduce_exponent(self) -> (Self, Self);

    /// `(eʳ − 1) / r − 1` by its series, for `|r| ≤ ½ ln 2`, to the float's precision.
    fn exp_series(r: Self) -> Self;
}

macro_rules! float {
    ($float:ident, $bits:ident, $shift:literal, $bias:literal, $magic:expr, $limit:literal,
     $ln2_high:expr, $ln2_low:expr, $series:expr,
     $vector:ident, $lanes:ident, $split:ident, $split_mut:ident, $splat:ident, $fma:ident,
     $add:ident, $mul:ident, $max:ident, $greater:ident, $select:ident, $across:ident, $load:ident, $store:ident) => {
        impl Float for $float {
            type Vector<S: Simd> = S::$vector;
            const NAME: &'static str = stringify!($float);

            #[inline(always)]
            fn lanes<S: Simd>() -> usize {
                S::$lanes
            }
            #[inline(always)]
            fn split<S: Simd>(slice: &[Self]) -> (&[S::$vector], &[Self]) {
                S::$split(slice)
            }
            #[inline(always)]
            fn split_mut<S: Simd>(slice: &mut [Self]) -> (&mut [S::$vector], &mut [Self]) {
                S::$split_mut(slice)
            }
            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> S::$vector {
                simd.$splat(value)
            }
            #[inline(always)]
            fn fused<S: Simd>(simd: S, a: S::$vector, b: S::$vector, c: S::$vector) -> S::$vector {
                simd.$fma(a, b, c)
            }
            #[inline(always)]
            fn plus<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$add(a, b)
            }
            #[inline(always)]
            fn times<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$mul(a, b)
            }
            #[inline(always)]
            fn larger<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$max(a, b)
            }
            #[inline(always)]
            fn gated<S: Simd>(
                simd: S,
                gate: S::$vector,
                x: S::$vector,
                slope: S::$vector,
            ) -> S::$vector {
                let positive = simd.$greater(gate, simd.$splat(0.0));
                simd.$select(positive, x, simd.$mul(x, slope))
            }
            #[inline(always)]
            fn across<S: Simd>(simd: S, a: S::$vector) -> Self {
                simd.$across(a)
            }
            #[inline(always)]
            fn load_part<S: Simd>(simd: S, slice: &[Self]) -> S::$vector {
                simd.$load(slice)
            }
            #[inline(always)]
            fn store_part<S: Simd>(simd: S, slice: &mut [Self], value: S::$vector) {
                simd.$store(slice, value);
            }
            #[inline(always)]
            fn narrow(value: f64) -> Self {
                value as $float
            }
            #[inline(always)]
            fn widen(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn fma(self, a: Self, b: Self) -> Self {
                $float::mul_add(self, a, b)
            }
            fn run_product(product: Product<'_, Self>) {
                arch().dispatch(product);
            }
            fn activate(activation: &Activation, z: &mut [Self]) {
                activation.apply_to_any_batch(z);
            }
            fn activate_with_slopes(activation: &Activation, z: &mut [Self], slopes: &mut [Self]) {
                activation.apply_to_any_batch_with_slopes(z, slopes);
            }
            fn activate_own(activation: &OwnActivation, z: &mut [Self]) {
                activation.batch(z);
            }
            fn activate_own_with_slopes(
                activation: &OwnActivation,
                z: &mut [Self],
                slopes: &mut [Self],
            ) {
                activation.batch_with_slopes(z, slopes);
            }
            #[inline(always)]
            fn magnitude(self) -> Self {
                $float::abs(self)
            }
            #[inline(always)]
            fn reduce_exponent(self) -> (Self, Self) {
                // Adding 1.5·2^p rounds to an integer, which then sits in the low bits.
                let x = if self > $limit { $limit } else { self };
                let x = if x < -$limit { -$limit } else { x };
                let shifted = $float::mul_add(x, std::$float::consts::LOG2_E, $magic);
                let n = shifted - $magic;
                let r = $float::mul_add(n, -$ln2_high, x);
                let r = $float::mul_add(n, -$ln2_low, r);
                let exponent = shifted.to_bits().wrapping_add($bias) << $shift;
                (r, $float::from_bits(exponent))
            }
            #[inline(always)]
            fn exp_series(r: Self) -> Self {
                let mut sum: $float = 0.0;
                for c in $series {
                    sum = $float::mul_add(sum, r, c);
                }
                sum * r
            }
        }
    };
}

// ln 2 in two parts: the high one has enough trailing zeros that n · high is exact. Series: 1/k! from
// the highest power down to 1/2!.
float!(
    f64,
    u64,
    52,
    1023,
    6_755_399_441_055_744.0_f64,
    708.0,
    0.693_147_180_369_123_8_f64,
    1.908_214_929_270_587_7e-10_f64,
    [
        1.0 / 87_178_291_200.0,
        1.0 / 6_227_020_800.0,
        1.0 / 479_001_600.0,
        1.0 / 39_916_800.0,
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5_040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
    ],
    f64s,
    F64_LANES,
    as_simd_f64s,
    as_mut_simd_f64s,
    splat_f64s,
    mul_add_e_f64s,
    add_f64s,
    mul_f64s,
    max_f64s,
    greater_than_f64s,
    select_f64s,
    reduce_sum_f64s,
    partial_load_f64s,
    partial_store_f64s
);
float!(
    f32,
    u32,
    23,
    127,
    12_582_912.0_f32,
    87.0,
    0.693_359_4_f32,
    -2.121_944_4e-4_f32,
    [1.0 / 40_320.0, 1.0 / 5_040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5],
    f32s,
    F32_LANES,
    as_simd_f32s,
    as_mut_simd_f32s,
    splat_f32s,
    mul_add_e_f32s,
    add_f32s,
    mul_f32s,
    max_f32s,
    greater_than_f32s,
    select_f32s,
    reduce_sum_f32s,
    partial_load_f32s,
    partial_store_f32s
);
