//! Value and slope of every elementary function, for any inner number.
//!
//! Slopes are written so that they neither overflow nor cancel where the function itself does not.

use super::spherical;
use num_dual::DualNum;
use pam_core::{ActivationFunction, Scalar, activation::Tanh};

/// A value and the slope there.
type Rule<T> = (T, T);

fn one<T: Scalar>() -> T {
    T::one()
}

pub(crate) fn recip<T: Scalar>(x: T) -> Rule<T> {
    let r = x.recip();
    (r, -r * r)
}

pub(crate) fn sqrt<T: Scalar>(x: T) -> Rule<T> {
    let r = x.sqrt();
    (r, r.recip().scaled(0.5))
}

pub(crate) fn cbrt<T: Scalar>(x: T) -> Rule<T> {
    let r = x.cbrt();
    (r, (r * r).scaled(3.0).recip())
}

pub(crate) fn exp<T: Scalar>(x: T) -> Rule<T> {
    let e = x.exp();
    (e, e)
}

pub(crate) fn exp2<T: Scalar>(x: T) -> Rule<T> {
    let e = x.exp2();
    (e, e.scaled(std::f64::consts::LN_2))
}

pub(crate) fn exp_m1<T: Scalar>(x: T) -> Rule<T> {
    let value = x.exp_m1();
    // The sum saves an exponential, but would cancel for large negative arguments.
    (value, if value.real() > -0.5 { value + one::<T>() } else { x.exp() })
}

pub(crate) fn ln<T: Scalar>(x: T) -> Rule<T> {
    (x.ln(), x.recip())
}

pub(crate) fn log<T: Scalar>(x: T, base: T::Primitive) -> Rule<T> {
    (x.log(base), x.recip() / DualNum::ln(&base))
}

pub(crate) fn log2<T: Scalar>(x: T) -> Rule<T> {
    (x.log2(), x.recip().scaled(std::f64::consts::LOG2_E))
}

pub(crate) fn log10<T: Scalar>(x: T) -> Rule<T> {
    (x.log10(), x.recip().scaled(std::f64::consts::LOG10_E))
}

pub(crate) fn ln_1p<T: Scalar>(x: T) -> Rule<T> {
    (x.ln_1p(), (one::<T>() + x).recip())
}

pub(crate) fn sin<T: Scalar>(x: T) -> Rule<T> {
    x.sin_cos()
}

pub(crate) fn cos<T: Scalar>(x: T) -> Rule<T> {
    let (sin, cos) = x.sin_cos();
    (cos, -sin)
}

pub(crate) fn tan<T: Scalar>(x: T) -> Rule<T> {
    let t = x.tan();
    (t, one::<T>() + t * t)
}

pub(crate) fn asin<T: Scalar>(x: T) -> Rule<T> {
    (x.asin(), ((one::<T>() - x) * (one::<T>() + x)).sqrt().recip())
}

pub(crate) fn acos<T: Scalar>(x: T) -> Rule<T> {
    (x.acos(), -((one::<T>() - x) * (one::<T>() + x)).sqrt().recip())
}

pub(crate) fn atan<T: Scalar>(x: T) -> Rule<T> {
    (x.atan(), (one::<T>() + x * x).recip())
}

/// `atan2(y, x)` with `∂/∂y = x / (x² + y²)` and `∂/∂x = −y / (x² + y²)`; the larger argument is
/// divided out, so that squares do not overflow.
pub(crate) fn atan2<T: Scalar>(y: T, x: T) -> (T, [T; 2]) {
    let angle = y.atan2(x);
    if x.real().abs() >= y.real().abs() {
        let q = y / x;
        let d = ((one::<T>() + q * q) * x).recip();
        (angle, [d, -q * d])
    } else {
        let q = x / y;
        let d = ((one::<T>() + q * q) * y).recip();
        (angle, [q * d, -d])
    }
}

pub(crate) fn sinh<T: Scalar>(x: T) -> Rule<T> {
    (x.sinh(), x.cosh())
}

pub(crate) fn cosh<T: Scalar>(x: T) -> Rule<T> {
    (x.cosh(), x.sinh())
}

/// The slope is `sech² x = 4 e^{−2|x|} / (1 + e^{−2|x|})²`: `1 − tanh²` would cancel far out. The dual
/// numbers of `num-dual` divide sinh by cosh, which overflows at 710, so inner duals take the form
/// through `e^{−2|x|}` for the value too.
pub(crate) fn tanh<T: Scalar>(x: T) -> Rule<T> {
    let value = if T::NDERIV == 0 { x.tanh() } else { Tanh.value(x) };
    let e = (-x.abs()).scaled(2.0).exp();
    let above = one::<T>() + e;
    (value, e.scaled(4.0) / (above * above))
}

/// The larger of 1 and |x| is divided out of `√(1 + x²)`.
pub(crate) fn asinh<T: Scalar>(x: T) -> Rule<T> {
    let slope = if x.real().abs() <= 1.0 {
        (one::<T>() + x * x).sqrt().recip()
    } else {
        let r = x.abs().recip();
        r / (one::<T>() + r * r).sqrt()
    };
    (x.asinh(), slope)
}

pub(crate) fn acosh<T: Scalar>(x: T) -> Rule<T> {
    (x.acosh(), ((x - one::<T>()).sqrt() * (x + one::<T>()).sqrt()).recip())
}

pub(crate) fn atanh<T: Scalar>(x: T) -> Rule<T> {
    (x.atanh(), ((one::<T>() - x) * (one::<T>() + x)).recip())
}

pub(crate) fn sph_j0<T: Scalar>(x: T) -> Rule<T> {
    (x.sph_j0(), -x * spherical::j1_over_x(x))
}

pub(crate) fn sph_j1<T: Scalar>(x: T) -> Rule<T> {
    (x.sph_j1(), spherical::j0(x) - spherical::j1_over_x(x).scaled(2.0))
}

pub(crate) fn sph_j2<T: Scalar>(x: T) -> Rule<T> {
    (x.sph_j2(), x * (spherical::j1_over_x(x) - spherical::j2_over_x2(x).scaled(3.0)))
}

pub(crate) fn powi<T: Scalar>(x: T, n: i32) -> Rule<T> {
    let slope = match n {
        0 => T::zero(),
        1 => one(),
        // n − 1 may not exist.
        i32::MIN => x.powi(n).scaled(f64::from(n)) / x,
        _ => x.powi(n - 1).scaled(f64::from(n)),
    };
    (x.powi(n), slope)
}

pub(crate) fn powf<T: Scalar>(x: T, n: T::Primitive) -> Rule<T> {
    let unit: T::Primitive = num_traits::One::one();
    let slope = if num_traits::Zero::is_zero(&n) { T::zero() } else { x.powf(n - unit) * n };
    (x.powf(n), slope)
}

/// `x^y` with `∂/∂x = y x^{y−1}` and `∂/∂y = x^y ln x`. For `x ≤ 0` the latter does not exist; it is
/// set to zero, so that bases of either sign go with exponents that are constant.
pub(crate) fn powd<T: Scalar>(x: T, y: T) -> (T, [T; 2]) {
    let value = x.powd(y);
    let along_x = if y.real() == 0.0 { T::zero() } else { y * x.powd(y - one::<T>()) };
    let along_y = if x.real() > 0.0 { value * x.ln() } else { T::zero() };
    (value, [along_x, along_y])
}

pub(crate) fn softplus<T: Scalar>(x: T) -> Rule<T> {
    (x.softplus(), x.sigmoid())
}

pub(crate) fn softplus_inverse<T: Scalar>(x: T) -> Rule<T> {
    (x.softplus_inverse(), -(-x).exp_m1().recip())
}

pub(crate) fn sigmoid<T: Scalar>(x: T) -> Rule<T> {
    let s = x.sigmoid();
    (s, s * (-x).sigmoid())
}
