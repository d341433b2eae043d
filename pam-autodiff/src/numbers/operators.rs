//! The operators and small traits that `num-dual` asks of a number, from a few operations.

use num_dual::{DualNum, DualNumFloat};
use pam_core::Scalar;

/// Basic operations from which the operators are made.
pub(crate) trait Arithmetic: Copy {
    /// The number inside: value and derivatives are of this type.
    type Inner: Scalar;

    /// A number without derivatives.
    fn lifted(value: Self::Inner) -> Self;

    /// The value.
    fn inner(self) -> Self::Inner;

    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn over(self, other: Self) -> Self;
    fn negated(self) -> Self;
    fn plus_plain(self, other: PrimitiveOf<Self>) -> Self;
    fn times_plain(self, factor: PrimitiveOf<Self>) -> Self;
    fn over_plain(self, divisor: PrimitiveOf<Self>) -> Self;

    /// `self − other · trunc(self / other)`, with the quotient taken of the real parts.
    fn remainder(self, other: Self) -> Self;
}

/// The float below a number.
pub(crate) type PrimitiveOf<A> = <<A as Arithmetic>::Inner as DualNum>::Primitive;

/// `trunc(a / b)` of the real parts: the number of times that `%` takes `b` away from `a`.
pub(crate) fn whole_quotient<T: DualNum>(a: &T, b: &T) -> T::Primitive {
    num_traits::Float::trunc(a.re() / b.re())
}

/// `a % b` of the inner numbers. Only plain floats have an exact remainder of their own.
pub(crate) fn inner_remainder<T: DualNum + Copy>(a: T, b: T) -> T {
    if T::NDERIV == 0 { a % b } else { a - b * whole_quotient(&a, &b) }
}

/// A float as an inner number.
pub(crate) fn lift<T: DualNum<Primitive = F>, F: DualNumFloat>(float: F) -> T {
    T::from(float)
}

/// Implements the operator traits of `DualNum` (all of it but the elementary functions) for a type
/// that is [`Arithmetic`] and `DualNum`: `number_operators!(impl[generics] Type, Inner, Primitive)`.
macro_rules! number_operators {
    (impl[$($generics:tt)*] $type:ty, $inner:ty, $primitive:ty) => {
        number_operators!(@binary [$($generics)*] $type, Add add plus, AddAssign add_assign);
        number_operators!(@binary [$($generics)*] $type, Sub sub minus, SubAssign sub_assign);
        number_operators!(@binary [$($generics)*] $type, Mul mul times, MulAssign mul_assign);
        number_operators!(@binary [$($generics)*] $type, Div div over, DivAssign div_assign);
        number_operators!(@binary [$($generics)*] $type, Rem rem remainder, RemAssign rem_assign);
        number_operators!(@plain [$($generics)*] $type, $primitive, Add add, AddAssign add_assign,
            |a, b| a.plus_plain(b));
        number_operators!(@plain [$($generics)*] $type, $primitive, Sub sub, SubAssign sub_assign,
            |a, b| a.plus_plain(-b));
        number_operators!(@plain [$($generics)*] $type, $primitive, Mul mul, MulAssign mul_assign,
            |a, b| a.times_plain(b));
        number_operators!(@plain [$($generics)*] $type, $primitive, Div div, DivAssign div_assign,
            |a, b| a.over_plain(b));
        number_operators!(@plain [$($generics)*] $type, $primitive, Rem rem, RemAssign rem_assign,
            |a, b| a.remainder(Self::from(b)));

        impl<$($generics)*> std::ops::Neg for $type {
            type Output = Self;
            #[inline]
            fn neg(self) -> Self {
                $crate::numbers::Arithmetic::negated(self)
            }
        }

        impl<$($generics)*> std::ops::Neg for &$type {
            type Output = $type;
            #[inline]
            fn neg(self) -> $type {
                -*self
            }
        }

        impl<$($generics)*> From<$primitive> for $type {
            #[inline]
            fn from(float: $primitive) -> Self {
                $crate::numbers::Arithmetic::lifted($crate::numbers::lift(float))
            }
        }

        impl<$($generics)*> num_traits::Zero for $type {
            #[inline]
            fn zero() -> Self {
                $crate::numbers::Arithmetic::lifted(<$inner>::zero())
            }
            #[inline]
            fn is_zero(&self) -> bool {
                $crate::numbers::Arithmetic::inner(*self).is_zero()
            }
        }

        impl<$($generics)*> num_traits::One for $type {
            #[inline]
            fn one() -> Self {
                $crate::numbers::Arithmetic::lifted(<$inner>::one())
            }
            #[inline]
            fn is_one(&self) -> bool {
                $crate::numbers::Arithmetic::inner(*self).is_one()
            }
        }

        impl<$($generics)*> num_traits::Num for $type {
            type FromStrRadixErr = <$inner as num_traits::Num>::FromStrRadixErr;
            fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
                <$inner>::from_str_radix(text, radix).map($crate::numbers::Arithmetic::lifted)
            }
        }

        impl<$($generics)*> num_traits::Signed for $type {
            #[inline]
            fn abs(&self) -> Self {
                if self.is_positive() { *self } else { -*self }
            }
            #[inline]
            fn abs_sub(&self, other: &Self) -> Self {
                if self > other { *self - *other } else { num_traits::Zero::zero() }
            }
            #[inline]
            fn signum(&self) -> Self {
                let inner = $crate::numbers::Arithmetic::inner(*self);
                $crate::numbers::Arithmetic::lifted(num_traits::Signed::signum(&inner))
            }
            #[inline]
            fn is_positive(&self) -> bool {
                num_traits::Signed::is_positive(&$crate::numbers::Arithmetic::inner(*self))
            }
            #[inline]
            fn is_negative(&self) -> bool {
                num_traits::Signed::is_negative(&$crate::numbers::Arithmetic::inner(*self))
            }
        }

        impl<$($generics)*> num_traits::Inv for $type {
            type Output = Self;
            #[inline]
            fn inv(self) -> Self {
                num_dual::DualNum::recip(&self)
            }
        }

        // No neutral start: on a tape it would be recorded.
        impl<$($generics)*> std::iter::Sum for $type {
            fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
                terms.reduce(|a, b| a + b).unwrap_or_else(num_traits::Zero::zero)
            }
        }

        impl<'a, $($generics)*> std::iter::Sum<&'a $type> for $type {
            fn sum<I: Iterator<Item = &'a Self>>(terms: I) -> Self {
                terms.copied().sum()
            }
        }

        impl<$($generics)*> std::iter::Product for $type {
            fn product<I: Iterator<Item = Self>>(factors: I) -> Self {
                factors.reduce(|a, b| a * b).unwrap_or_else(num_traits::One::one)
            }
        }

        impl<'a, $($generics)*> std::iter::Product<&'a $type> for $type {
            fn product<I: Iterator<Item = &'a Self>>(factors: I) -> Self {
                factors.copied().product()
            }
        }

        impl<$($generics)*> num_traits::FromPrimitive for $type {
            number_operators!(@from $primitive, from_i64 i64, from_u64 u64, from_f32 f32, from_f64 f64);
        }

        impl<$($generics)*> num_dual::DualStruct for $type {
            type Real = $primitive;
            type Inner = $inner;
            #[inline]
            fn re(&self) -> $primitive {
                num_dual::DualStruct::re(&$crate::numbers::Arithmetic::inner(*self))
            }
            #[inline]
            fn from_inner(inner: &$inner) -> Self {
                $crate::numbers::Arithmetic::lifted(*inner)
            }
        }

        impl<$($generics)*> num_dual::Mappable<Self> for $type {
            type Output<O> = O;
            #[inline]
            fn map_dual<M: Fn(Self) -> O, O>(self, f: M) -> O {
                f(self)
            }
        }

        /// By the real part only, so that every number takes the branches of a plain run.
        impl<$($generics)*> PartialEq for $type {
            #[inline]
            fn eq(&self, other: &Self) -> bool {
                num_dual::DualStruct::re(self) == num_dual::DualStruct::re(other)
            }
        }

        /// By the real part only.
        impl<$($generics)*> PartialEq<$primitive> for $type {
            #[inline]
            fn eq(&self, other: &$primitive) -> bool {
                num_dual::DualStruct::re(self) == *other
            }
        }

        /// By the real part only, so that every number takes the branches of a plain run.
        impl<$($generics)*> PartialOrd for $type {
            #[inline]
            fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
                num_dual::DualStruct::re(self).partial_cmp(&num_dual::DualStruct::re(other))
            }
        }

        /// By the real part only.
        impl<$($generics)*> PartialOrd<$primitive> for $type {
            #[inline]
            fn partial_cmp(&self, other: &$primitive) -> Option<std::cmp::Ordering> {
                num_dual::DualStruct::re(self).partial_cmp(other)
            }
        }
    };

    (@binary [$($generics:tt)*] $type:ty, $trait:ident $method:ident $operation:ident,
     $assign:ident $assign_method:ident) => {
        impl<$($generics)*> std::ops::$trait for $type {
            type Output = $type;
            #[inline]
            fn $method(self, other: $type) -> $type {
                $crate::numbers::Arithmetic::$operation(self, other)
            }
        }

        impl<$($generics)*> std::ops::$trait<&$type> for $type {
            type Output = $type;
            #[inline]
            fn $method(self, other: &$type) -> $type {
                $crate::numbers::Arithmetic::$operation(self, *other)
            }
        }

        impl<$($generics)*> std::ops::$trait<$type> for &$type {
            type Output = $type;
            #[inline]
            fn $method(self, other: $type) -> $type {
                $crate::numbers::Arithmetic::$operation(*self, other)
            }
        }

        impl<$($generics)*> std::ops::$trait<&$type> for &$type {
            type Output = $type;
            #[inline]
            fn $method(self, other: &$type) -> $type {
                $crate::numbers::Arithmetic::$operation(*self, *other)
            }
        }

        impl<$($generics)*> std::ops::$assign for $type {
            #[inline]
            fn $assign_method(&mut self, other: $type) {
                *self = $crate::numbers::Arithmetic::$operation(*self, other);
            }
        }
    };

    (@plain [$($generics:tt)*] $type:ty, $primitive:ty, $trait:ident $method:ident,
     $assign:ident $assign_method:ident, |$a:ident, $b:ident| $body:expr) => {
        impl<$($generics)*> std::ops::$trait<$primitive> for $type {
            type Output = $type;
            #[inline]
            fn $method(self, other: $primitive) -> $type {
                use $crate::numbers::Arithmetic as _;
                let ($a, $b) = (self, other);
                $body
            }
        }

        impl<$($generics)*> std::ops::$assign<$primitive> for $type {
            #[inline]
            fn $assign_method(&mut self, other: $primitive) {
                use $crate::numbers::Arithmetic as _;
                let ($a, $b) = (*self, other);
                *self = $body;
            }
        }
    };

    (@from $primitive:ty, $($function:ident $from:ty),+) => {
        $(#[inline]
        fn $function(number: $from) -> Option<Self> {
            <$primitive as num_traits::FromPrimitive>::$function(number).map(Self::from)
        })+
    };
}
