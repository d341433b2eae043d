//! Complex numbers for the complex-step method.
//!
//! A real analytic `f` obeys `f(x + ih) = f(x) + ih f'(x) − h² f''(x)/2 − …`, so `Im f(x + ih) / h` is
//! `f'(x)` to `O(h²)` with no difference of near numbers: `h` can be 1e-40. Sources: W. Squire and
//! G. Trapp, *Using Complex Variables to Estimate Derivatives of Real Functions* (1998); J. Martins,
//! P. Sturdza and J. Alonso, *The Complex-Step Derivative Approximation* (2003), which also shows that
//! textbook formulas lose a tiny imaginary part. The functions here keep it: inverse functions follow
//! W. Kahan, *Branch Cuts for Complex Elementary Functions* (1987).

use super::{Arithmetic, spherical};
use num_dual::DualNum;
use pam_core::Scalar;
use std::fmt;

/// A complex number `re + i·im` that takes the branches of its real part.
///
/// Arithmetic and functions are the true complex ones, continued from the real axis: `abs` is `±z` by
/// the sign of the real part, and where the real function is undefined (`ln` of a negative number,
/// `asin` of 2) the result is not a number, as in a plain run. It runs any function that is generic
/// over the scalar; see [`ComplexDifference`](crate::ComplexDifference) for derivatives.
///
/// ```
/// use num_dual::DualNum;
/// use pam_autodiff::ComplexStep;
/// let z = ComplexStep::new(0.3, 1e-40).sin();
/// assert!((z.im / 1e-40 - 0.3_f64.cos()).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct ComplexStep {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

impl ComplexStep {
    /// `re + i·im`.
    #[inline]
    #[must_use]
    pub fn new(re: f64, im: f64) -> Self {
        Self { re, im }
    }

    /// Not a number if `defined` is false.
    fn only_if(self, defined: bool) -> Self {
        if defined { self } else { Self::new(f64::NAN, f64::NAN) }
    }

    /// `i z`.
    fn turned(self) -> Self {
        Self::new(-self.im, self.re)
    }

    fn conj(self) -> Self {
        Self::new(self.re, -self.im)
    }

    /// `|z|^p e^{ip arg z}` for a positive real part, by logarithm and exponential.
    fn polar_power(self, p: f64) -> Self {
        let (sin, cos) = (p * self.im.atan2(self.re)).sin_cos();
        let r = self.re.hypot(self.im).powf(p);
        Self::new(r * cos, r * sin)
    }

    /// The principal square root of a number with a real part that is not negative.
    fn root(self) -> Self {
        let s = self.re.midpoint(self.re.hypot(self.im)).sqrt();
        if s == 0.0 { Self::new(0.0, 0.0) } else { Self::new(s, 0.5 * self.im / s) }
    }

    /// Kahan's arcsine, for a real part in [−1, 1].
    fn arcsine(self) -> Self {
        let (below, above) = ((one() - self).root(), (one() + self).root());
        Self::new(self.re.atan2((below * above).re), (below.conj() * above).im.asinh())
    }
}

fn one() -> ComplexStep {
    ComplexStep::new(1.0, 0.0)
}

impl Arithmetic for ComplexStep {
    type Inner = f64;

    #[inline]
    fn lifted(value: f64) -> Self {
        Self::new(value, 0.0)
    }
    #[inline]
    fn inner(self) -> f64 {
        self.re
    }
    #[inline]
    fn plus(self, other: Self) -> Self {
        Self::new(self.re + other.re, self.im + other.im)
    }
    #[inline]
    fn minus(self, other: Self) -> Self {
        Self::new(self.re - other.re, self.im - other.im)
    }
    #[inline]
    fn times(self, other: Self) -> Self {
        let re = self.re * other.re - self.im * other.im;
        Self::new(re, self.re * other.im + self.im * other.re)
    }
    /// Smith's division: neither squares nor overflows early.
    #[inline]
    fn over(self, other: Self) -> Self {
        if other.re.abs() >= other.im.abs() {
            let q = other.im / other.re;
            let d = other.re + other.im * q;
            Self::new((self.re + self.im * q) / d, (self.im - self.re * q) / d)
        } else {
            let q = other.re / other.im;
            let d = other.re * q + other.im;
            Self::new((self.re * q + self.im) / d, (self.im * q - self.re) / d)
        }
    }
    #[inline]
    fn negated(self) -> Self {
        Self::new(-self.re, -self.im)
    }
    #[inline]
    fn plus_plain(self, other: f64) -> Self {
        Self::new(self.re + other, self.im)
    }
    #[inline]
    fn times_plain(self, factor: f64) -> Self {
        Self::new(self.re * factor, self.im * factor)
    }
    #[inline]
    fn over_plain(self, divisor: f64) -> Self {
        Self::new(self.re / divisor, self.im / divisor)
    }
    #[inline]
    fn remainder(self, other: Self) -> Self {
        let quotient = (self.re / other.re).trunc();
        Self::new(self.re % other.re, self.im - other.im * quotient)
    }
}

number_operators!(impl[] ComplexStep, f64, f64);

impl DualNum for ComplexStep {
    type Primitive = f64;
    const NDERIV: usize = 1;
    type InnerDual = f64;

    fn from_re(re: f64) -> Self {
        Self::new(re, 0.0)
    }
    fn scale(self, factor: &f64) -> Self {
        self.times_plain(*factor)
    }
    fn recip(&self) -> Self {
        one() / *self
    }
    fn powi(&self, n: i32) -> Self {
        let (mut power, mut square, mut rest) = (one(), *self, n.unsigned_abs());
        while rest > 0 {
            if rest & 1 == 1 {
                power *= square;
            }
            square *= square;
            rest >>= 1;
        }
        if n < 0 { power.recip() } else { power }
    }
    fn powf(&self, n: f64) -> Self {
        // Whole exponents are defined for negative bases too.
        if n.fract() == 0.0 && n.abs() <= f64::from(i32::MAX) {
            self.powi(n as i32)
        } else {
            self.polar_power(n).only_if(self.re >= 0.0)
        }
    }
    fn powd(&self, exponent: Self) -> Self {
        if exponent.im == 0.0 { self.powf(exponent.re) } else { (self.ln() * exponent).exp() }
    }
    fn sqrt(&self) -> Self {
        self.root().only_if(self.re >= 0.0)
    }
    fn cbrt(&self) -> Self {
        if self.re < 0.0 { -(-*self).cbrt() } else { self.polar_power(1.0 / 3.0) }
    }
    fn exp(&self) -> Self {
        let (sin, cos) = self.im.sin_cos();
        let e = self.re.exp();
        Self::new(e * cos, e * sin)
    }
    fn exp2(&self) -> Self {
        let (sin, cos) = (self.im * std::f64::consts::LN_2).sin_cos();
        let e = self.re.exp2();
        Self::new(e * cos, e * sin)
    }
    fn exp_m1(&self) -> Self {
        let half = (0.5 * self.im).sin();
        let re = self.re.exp_m1() * self.im.cos() - 2.0 * half * half;
        Self::new(re, self.re.exp() * self.im.sin())
    }
    fn ln(&self) -> Self {
        let z = Self::new(self.re.hypot(self.im).ln(), self.im.atan2(self.re));
        z.only_if(self.re >= 0.0)
    }
    fn log(&self, base: f64) -> Self {
        self.ln() / base.ln()
    }
    fn log2(&self) -> Self {
        self.ln() * std::f64::consts::LOG2_E
    }
    fn log10(&self) -> Self {
        self.ln() * std::f64::consts::LOG10_E
    }
    fn ln_1p(&self) -> Self {
        let (x, h) = (self.re, self.im);
        let re = if x.abs() < 0.5 {
            0.5 * (x * (2.0 + x) + h * h).ln_1p()
        } else {
            (1.0 + x).hypot(h).ln()
        };
        Self::new(re, h.atan2(1.0 + x)).only_if(x >= -1.0)
    }
    fn sin(&self) -> Self {
        self.sin_cos().0
    }
    fn cos(&self) -> Self {
        self.sin_cos().1
    }
    fn tan(&self) -> Self {
        let (sin, cos) = self.re.sin_cos();
        let (sinh, cosh) = (self.im.sinh(), self.im.cosh());
        let d = cos * cos + sinh * sinh;
        Self::new(sin * cos / d, sinh * cosh / d)
    }
    fn sin_cos(&self) -> (Self, Self) {
        let (sin, cos) = self.re.sin_cos();
        let (sinh, cosh) = (self.im.sinh(), self.im.cosh());
        (Self::new(sin * cosh, cos * sinh), Self::new(cos * cosh, -sin * sinh))
    }
    fn asin(&self) -> Self {
        self.arcsine().only_if(self.re.abs() <= 1.0)
    }
    fn acos(&self) -> Self {
        let (below, above) = ((one() - *self).root(), (one() + *self).root());
        let z = Self::new(2.0 * below.re.atan2(above.re), (above.conj() * below).im.asinh());
        z.only_if(self.re.abs() <= 1.0)
    }
    fn atan(&self) -> Self {
        let (x, h) = (self.re, self.im);
        let re = if x.abs() < 1.0 {
            0.5 * (2.0 * x).atan2((1.0 - x) * (1.0 + x) - h * h)
        } else {
            // The same angle with x² divided out.
            let r = x.recip();
            0.5 * (2.0 * r).atan2((r - 1.0) * (r + 1.0) - (h * r) * (h * r))
        };
        let r = x.hypot(1.0 - h).recip();
        Self::new(re, 0.25 * (4.0 * h * r * r).ln_1p())
    }
    fn atan2(&self, other: Self) -> Self {
        // The angle differs from an arctangent by quarter turns, which the real parts tell; the quotient
        // is taken such that its size stays below one.
        let arctangent = if other.re.abs() >= self.re.abs() {
            (*self / other).atan()
        } else {
            -(other / *self).atan()
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        let turns = ((self.re.atan2(other.re) - arctangent.re) / quarter).round();
        arctangent + turns * quarter
    }
    fn sinh(&self) -> Self {
        let (sin, cos) = self.im.sin_cos();
        Self::new(self.re.sinh() * cos, self.re.cosh() * sin)
    }
    fn cosh(&self) -> Self {
        let (sin, cos) = self.im.sin_cos();
        Self::new(self.re.cosh() * cos, self.re.sinh() * sin)
    }
    fn tanh(&self) -> Self {
        let (sin, cos) = self.im.sin_cos();
        if self.re.abs() > 20.0 {
            // sinh² and cosh² are e^{2|x|}/4 here, and would overflow further out.
            let im = 4.0 * sin * cos * (-2.0 * self.re.abs()).exp();
            return Self::new(1.0_f64.copysign(self.re), im);
        }
        let (sinh, cosh) = (self.re.sinh(), self.re.cosh());
        let d = sinh * sinh + cos * cos;
        Self::new(sinh * cosh / d, sin * cos / d)
    }
    fn asinh(&self) -> Self {
        // The continuation of the arcsine along the imaginary axis: asinh z = i asin(−i z). Kahan's
        // product of roots holds there for any size.
        let w = -self.turned();
        w.arcsine().turned()
    }
    fn acosh(&self) -> Self {
        let (below, above) = ((*self - one()).root(), (*self + one()).root());
        let z = Self::new((below.conj() * above).re.asinh(), 2.0 * below.im.atan2(above.re));
        z.only_if(self.re >= 1.0)
    }
    fn atanh(&self) -> Self {
        let (x, h) = (self.re.abs(), self.im);
        let away = (1.0 - x).hypot(h);
        let re = (0.25 * (4.0 * x / (away * away)).ln_1p()).copysign(self.re);
        let im = 0.5 * (2.0 * h).atan2((1.0 - x) * (1.0 + x) - h * h);
        Self::new(re, im).only_if(x <= 1.0)
    }
    fn sph_j0(&self) -> Self {
        spherical::j0(*self)
    }
    fn sph_j1(&self) -> Self {
        *self * spherical::j1_over_x(*self)
    }
    fn sph_j2(&self) -> Self {
        *self * *self * spherical::j2_over_x2(*self)
    }
}

impl Scalar for ComplexStep {}

impl fmt::Display for ComplexStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} + {}i", self.re, self.im)
    }
}
