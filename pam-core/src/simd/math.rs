//! Branch-free elementary functions, so that a loop over a slice becomes vector instructions.
//!
//! Accurate to a few units in the last place; the generic [`Scalar`](crate::Scalar) functions are the
//! reference that tests hold them to. Arguments past the range of the exponential saturate.

use super::Float;

/// `eˣ − 1` and `eˣ`.
#[inline(always)]
pub fn exp_m1_and_exp<T: Float>(x: T) -> (T, T) {
    let (r, scale) = x.reduce_exponent();
    let p = r.fma(T::exp_series(r), r);
    (scale.fma(p, scale - T::narrow(1.0)), scale.fma(p, scale))
}

/// `tanh x`.
#[inline(always)]
pub fn tanh<T: Float>(x: T) -> T {
    let (e, _) = exp_m1_and_exp(x.magnitude() * T::narrow(-2.0));
    let t = -e / (e + T::narrow(2.0));
    if x < T::narrow(0.0) { -t } else { t }
}

/// The logistic function `1 / (1 + e⁻ˣ)`.
#[inline(always)]
pub fn sigmoid<T: Float>(x: T) -> T {
    let (_, e) = exp_m1_and_exp(-x.magnitude());
    let one = T::narrow(1.0);
    let small = e / (one + e);
    if x > T::narrow(0.0) { one / (one + e) } else { small }
}

/// `ln(1 + u)` for `0 ≤ u ≤ 1`, as `2 artanh(u / (2 + u))` by its series.
#[inline(always)]
pub fn ln_1p_unit<T: Float>(u: T) -> T {
    let s = u / (u + T::narrow(2.0));
    let s2 = s * s;
    let mut sum = T::narrow(0.0);
    for k in (0..17).rev() {
        sum = sum.fma(s2, T::narrow(2.0 / (2.0 * f64::from(k) + 1.0)));
    }
    sum * s
}
