//! What the loops over whole vectors share.

use crate::network::LANES;
use pulp::Simd;

/// The numbers of the lanes of a block.
pub(crate) const LANE_NUMBERS: [u64; LANES] = [0, 1, 2, 3, 4, 5, 6, 7];

/// Whether no lane of a mask is set. (Which lane is the first does not mean the same on all instruction
/// sets.)
#[inline(always)]
pub(crate) fn none<S: Simd>(simd: S, mask: S::m64s) -> bool {
    simd.first_true_m64s(mask) >= S::F64_LANES
}

/// `β x + γ v` of several sides.
#[inline(always)]
pub(crate) fn along<S: Simd>(
    simd: S,
    (beta, gamma): (S::f64s, S::f64s),
    [x, v]: [f64; 2],
) -> S::f64s {
    simd.mul_add_f64s(beta, simd.splat_f64s(x), simd.mul_f64s(gamma, simd.splat_f64s(v)))
}

/// Puts a number in place of the last bits of a value, those that `rest` leaves out: one extreme of such
/// values finds both the value and whose it is.
#[inline(always)]
pub(crate) fn tagged<S: Simd>(simd: S, value: S::f64s, rest: S::u64s, number: S::u64s) -> S::f64s {
    let bits = simd.and_u64s(simd.transmute_u64s_f64s(value), rest);
    simd.transmute_f64s_u64s(simd.or_u64s(bits, number))
}
