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

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the standard library, relative to the larger of value and 1e-300.
    fn worst<T: Float>(fast: impl Fn(T) -> T, exact: impl Fn(f64) -> f64, range: f64) -> f64 {
        (-4000..=4000)
            .map(|k| T::narrow(f64::from(k) / 4000.0 * range))
            .chain([1e-12, -1e-7, 3e-4].map(T::narrow))
            .map(|x| {
                let e = exact(x.widen());
                (fast(x).widen() - e).abs() / e.abs().max(1e-300)
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn elementary_functions_are_accurate() {
        assert!(worst::<f64>(|x| exp_m1_and_exp(x).1, f64::exp, 700.0) < 4e-16);
        assert!(worst::<f64>(|x| exp_m1_and_exp(x).0, f64::exp_m1, 3.0) < 1e-15);
        assert!(worst::<f64>(tanh, f64::tanh, 20.0) < 1e-15);
        assert!(worst::<f64>(sigmoid, |x| 1.0 / (1.0 + (-x).exp()), 30.0) < 1e-15);
        assert!(worst::<f64>(|x| ln_1p_unit(x.magnitude()), |x| x.abs().ln_1p(), 1.0) < 1e-15);
        assert!(worst::<f32>(|x| exp_m1_and_exp(x).1, f64::exp, 80.0) < 3e-7);
        assert!(worst::<f32>(|x| exp_m1_and_exp(x).0, f64::exp_m1, 3.0) < 4e-7);
        assert!(worst::<f32>(tanh, f64::tanh, 9.0) < 4e-7);
        assert!(worst::<f32>(|x| ln_1p_unit(x.magnitude()), |x| x.abs().ln_1p(), 1.0) < 4e-7);
    }

    #[test]
    fn arguments_out_of_range_saturate() {
        assert_eq!(tanh(1e4_f64), 1.0);
        assert_eq!(tanh(-1e30_f32), -1.0);
        assert_eq!(sigmoid(1e4_f64), 1.0);
        assert!(sigmoid(-1e4_f64) < 1e-300);
        assert!(tanh(f64::NAN).is_nan());
    }
}
