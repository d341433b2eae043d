//! Helpers for loops over whole SIMD vectors.

use pulp::Simd;

/// Rows are padded to multiples of this length: one vector of the widest instruction set.
pub(crate) const LANES: usize = 8;

/// The numbers of the lanes of a block.
pub(crate) const LANE_NUMBERS: [u64; LANES] = [0, 1, 2, 3, 4, 5, 6, 7];

/// True if no lane of a mask is set. (The order of the lanes differs between instruction sets.)
#[inline(always)]
pub(crate) fn none<S: Simd>(simd: S, mask: S::m64s) -> bool {
    simd.first_true_m64s(mask) >= S::F64_LANES
}

/// The linear forms `β x + γ v` of several facets.
#[inline(always)]
pub(crate) fn linear_form<S: Simd>(
    simd: S,
    [beta, gamma]: [S::f64s; 2],
    [x, v]: [f64; 2],
) -> S::f64s {
    simd.mul_add_f64s(beta, simd.splat_f64s(x), simd.mul_f64s(gamma, simd.splat_f64s(v)))
}

/// Keeps the bits `kept` of a value and stores an index in the others: the minimum or maximum of such
/// values is found together with its index.
#[inline(always)]
pub(crate) fn tagged<S: Simd>(simd: S, value: S::f64s, kept: S::u64s, index: S::u64s) -> S::f64s {
    let bits = simd.and_u64s(simd.transmute_u64s_f64s(value), kept);
    simd.transmute_f64s_u64s(simd.or_u64s(bits, index))
}

/// Sets a buffer to `len` zeros.
pub(crate) fn zero(buffer: &mut Vec<f64>, len: usize) {
    buffer.clear();
    buffer.resize(len, 0.0);
}
