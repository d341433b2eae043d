//! The generic scalar: one bound under which all physics is written.
//!
//! [`Scalar`] adds to `num_dual::DualNum` what models need and dual numbers lack (comparisons by
//! real part, softplus, scaling by a plain number) and one hook, [`Scalar::affine_into`], through
//! which the plain floats reach vector instructions. Every number type of `num-dual` that is `Copy`
//! is a `Scalar`, as are `f32` and `f64`; a reverse-mode variable implements the same trait.

mod affine;

use num_dual::{Dual, Dual2, Dual3, DualNum, HyperDual, HyperHyperDual};
use num_traits::{FromPrimitive, ToPrimitive};

/// A number that a model can run with.
///
/// Comparisons look at the real part only, so a dual run takes the same branches as a plain one.
///
/// ```
/// use num_dual::Dual64;
/// use pam_core::Scalar;
///
/// fn cube<S: Scalar>(x: S) -> S {
///     x * x * x + S::constant(1.0)
/// }
///
/// assert_eq!(cube(2.0), 9.0);
/// let slope = cube(Dual64::new(2.0, 1.0)); // the value with its derivative
/// assert_eq!((slope.re, slope.eps), (9.0, 12.0));
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no number that a model can run with",
    label = "a scalar is needed here",
    note = "scalars are `f64`, `f32`, the dual numbers of `num_dual` and the numbers of `pam_autodiff`; a function \
            over any of them begins with `fn name<S: Scalar>(…)`"
)]
pub trait Scalar: DualNum + Copy + 'static {
    /// Whether it is a value with several first derivatives and nothing else, so that the slopes of an expression are cheaper
    /// found once with plain numbers and [added](Self::add_along) than carried through it.
    const HAS_SEVERAL_SLOPES: bool = false;

    /// The constant `value`, with no derivative.
    #[inline]
    fn constant(value: f64) -> Self {
        Self::from(Self::Primitive::from_f64(value).expect("every f64 rounds to a float"))
    }

    /// The real part as `f64`.
    #[inline]
    fn real(self) -> f64 {
        self.re().to_f64().expect("every float widens to f64")
    }

    /// `self · factor` for a plain number, without a derivative of the factor.
    #[inline]
    fn scaled(self, factor: f64) -> Self {
        self * Self::Primitive::from_f64(factor).expect("every f64 rounds to a float")
    }

    /// The number `value` with the derivatives of `Σ slopes · arguments`: the result of a function whose value and slopes were
    /// computed with plain numbers.
    #[inline]
    fn with_slopes<const K: usize>(value: f64, arguments: [&Self; K], slopes: [f64; K]) -> Self {
        let mut sum = Self::constant(value);
        if Self::NDERIV == 0 {
            return sum;
        }
        for (argument, slope) in arguments.into_iter().zip(slopes) {
            sum += (*argument - Self::constant(argument.real())).scaled(slope);
        }
        sum
    }

    /// Adds the derivatives of `slope · argument` to its own; the value stays.
    #[inline]
    fn add_along(&mut self, argument: &Self, slope: f64) {
        *self += (*argument - Self::constant(argument.real())).scaled(slope);
    }

    /// `Σ factors · terms` for plain factors, in one pass.
    #[inline]
    fn combination<const K: usize>(terms: [&Self; K], factors: [f64; K]) -> Self {
        let products = terms.iter().zip(factors).map(|(term, factor)| term.scaled(factor));
        products.fold(Self::zero(), |sum, product| sum + product)
    }

    /// The larger of two numbers by real part; the first one on a tie.
    #[inline]
    fn maximum(self, other: Self) -> Self {
        if other.real() > self.real() { other } else { self }
    }

    /// The smaller of two numbers by real part; the first one on a tie.
    #[inline]
    fn minimum(self, other: Self) -> Self {
        if other.real() < self.real() { other } else { self }
    }

    /// `self` limited to `[low, high]`; outside, the derivative is that of the bound.
    #[inline]
    fn clamped(self, low: Self, high: Self) -> Self {
        self.maximum(low).minimum(high)
    }

    /// `ln(1 + eˣ)`, evaluated without overflow on either side.
    #[inline]
    fn softplus(self) -> Self {
        if self.real() > 0.0 { self + (-self).exp().ln_1p() } else { self.exp().ln_1p() }
    }

    /// Inverse of [`softplus`](Scalar::softplus), `ln(eˣ − 1)`, for `x > 0`.
    #[inline]
    fn softplus_inverse(self) -> Self {
        self + (-(-self).exp_m1()).ln()
    }

    /// The logistic function `1 / (1 + e⁻ˣ)`, evaluated without overflow on either side.
    #[inline]
    fn sigmoid(self) -> Self {
        let one = Self::constant(1.0);
        if self.real() > 0.0 {
            one / (one + (-self).exp())
        } else {
            let e = self.exp();
            e / (one + e)
        }
    }

    /// One dense layer without activation: `out[j] = bias[j] + Σ_i input[i] · columns[i·n + j]`,
    /// where `n = out.len()` and `columns` holds the weight matrix column by column.
    ///
    /// # Panics
    /// If the lengths do not fit.
    fn affine_into(columns: &[Self], bias: &[Self], input: &[Self], out: &mut [Self]) {
        assert_eq!(columns.len(), input.len() * out.len(), "weights do not fit the layer");
        out.copy_from_slice(bias);
        for (column, &x) in columns.chunks_exact(out.len()).zip(input) {
            for (o, &w) in out.iter_mut().zip(column) {
                *o += w * x;
            }
        }
    }
}

impl Scalar for f64 {
    #[inline]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline]
    fn real(self) -> f64 {
        self
    }
    #[inline]
    fn scaled(self, factor: f64) -> Self {
        self * factor
    }
    #[inline]
    fn affine_into(columns: &[Self], bias: &[Self], input: &[Self], out: &mut [Self]) {
        affine::affine(columns, bias, input, out);
    }
}

impl Scalar for f32 {
    #[inline]
    fn affine_into(columns: &[Self], bias: &[Self], input: &[Self], out: &mut [Self]) {
        affine::affine(columns, bias, input, out);
    }
}

impl<T: Scalar> Scalar for Dual<T> where Self: DualNum {}
impl<T: Scalar> Scalar for Dual2<T> where Self: DualNum {}
impl<T: Scalar> Scalar for Dual3<T> where Self: DualNum {}
impl<T: Scalar> Scalar for HyperDual<T> where Self: DualNum {}
impl<T: Scalar> Scalar for HyperHyperDual<T> where Self: DualNum {}

/// A slice of zeros to be used as scratch memory.
#[must_use]
pub fn zeros<S: Scalar>(len: usize) -> Vec<S> {
    vec![S::zero(); len]
}

/// The smooth step `3u² − 2u³` with `u = since/width + ½` between 0 and 1: 0 before, 1 behind, ½ at zero.
#[inline]
pub fn smooth_step<S: Scalar>(since: S, width: S) -> S {
    // Most calls are outside of the step, where nothing has a derivative.
    let real = since.real() / width.real() + 0.5;
    if real <= 0.0 {
        return S::zero();
    }
    if real >= 1.0 {
        return S::constant(1.0);
    }
    let u = since / width + S::constant(0.5);
    u * u * (S::constant(3.0) - u.scaled(2.0))
}
