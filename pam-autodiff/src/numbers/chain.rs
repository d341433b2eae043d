//! The elementary functions of `DualNum` from the chain rule.

use super::operators::{Arithmetic, PrimitiveOf, inner_remainder, lift, whole_quotient};
use num_dual::DualNum;
use num_traits::One;
use pam_core::Scalar;

/// A number that knows the chain rule for functions of one and of two arguments.
pub(crate) trait ChainRule: Copy {
    /// The number inside: value and derivatives are of this type.
    type Inner: Scalar;

    /// A number without derivatives.
    fn lifted(value: Self::Inner) -> Self;

    /// The value.
    fn inner(self) -> Self::Inner;

    /// `f(self)` with the value `f` and the slope `f'`.
    fn chain(self, value: Self::Inner, slope: Self::Inner) -> Self;

    /// `f(self, other)` with its value and its two partial derivatives.
    fn chain2(
        self,
        other: Self,
        value: Self::Inner,
        d_self: Self::Inner,
        d_other: Self::Inner,
    ) -> Self;
}

impl<C: ChainRule> Arithmetic for C {
    type Inner = <C as ChainRule>::Inner;

    #[inline(always)]
    fn lifted(value: Self::Inner) -> Self {
        ChainRule::lifted(value)
    }
    #[inline(always)]
    fn inner(self) -> Self::Inner {
        ChainRule::inner(self)
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        let one = <C as ChainRule>::Inner::one();
        self.chain2(other, ChainRule::inner(self) + ChainRule::inner(other), one, one)
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        let one = <C as ChainRule>::Inner::one();
        self.chain2(other, ChainRule::inner(self) - ChainRule::inner(other), one, -one)
    }
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        let (a, b) = (ChainRule::inner(self), ChainRule::inner(other));
        self.chain2(other, a * b, b, a)
    }
    #[inline]
    fn over(self, other: Self) -> Self {
        let (a, b) = (ChainRule::inner(self), ChainRule::inner(other));
        let (quotient, inverse) = (a / b, b.recip());
        self.chain2(other, quotient, inverse, -quotient * inverse)
    }
    #[inline(always)]
    fn negated(self) -> Self {
        self.chain(-ChainRule::inner(self), -<C as ChainRule>::Inner::one())
    }
    #[inline(always)]
    fn plus_plain(self, other: PrimitiveOf<Self>) -> Self {
        self.chain(ChainRule::inner(self) + other, <C as ChainRule>::Inner::one())
    }
    #[inline(always)]
    fn times_plain(self, factor: PrimitiveOf<Self>) -> Self {
        self.chain(ChainRule::inner(self) * factor, lift(factor))
    }
    #[inline]
    fn over_plain(self, divisor: PrimitiveOf<Self>) -> Self {
        self.chain(ChainRule::inner(self) / divisor, lift(DualNum::recip(&divisor)))
    }
    #[inline]
    fn remainder(self, other: Self) -> Self {
        let (a, b) = (ChainRule::inner(self), ChainRule::inner(other));
        let quotient: Self::Inner = lift(whole_quotient(&a, &b));
        self.chain2(other, inner_remainder(a, b), <C as ChainRule>::Inner::one(), -quotient)
    }
}

/// Implements `DualNum` for a [`ChainRule`] type:
/// `dual_num_by_chain_rule!(impl[generics] Type, Inner, Primitive)`.
macro_rules! dual_num_by_chain_rule {
    (impl[$($generics:tt)*] $type:ty, $inner:ty, $primitive:ty) => {
        impl<$($generics)*> num_dual::DualNum for $type {
            type Primitive = $primitive;
            const NDERIV: usize = <$inner as num_dual::DualNum>::NDERIV + 1;
            type InnerDual = $inner;

            #[inline]
            fn from_re(re: $inner) -> Self {
                $crate::numbers::ChainRule::lifted(re)
            }
            #[inline]
            fn scale(self, factor: &$inner) -> Self {
                use $crate::numbers::ChainRule as _;
                self.chain(self.inner() * *factor, *factor)
            }

            dual_num_by_chain_rule!(@unary recip sqrt cbrt exp exp2 exp_m1 ln log2 log10 ln_1p
                sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh sph_j0 sph_j1 sph_j2);

            #[inline]
            fn powi(&self, n: i32) -> Self {
                use $crate::numbers::ChainRule as _;
                let (value, slope) = $crate::numbers::rules::powi(self.inner(), n);
                self.chain(value, slope)
            }
            #[inline]
            fn powf(&self, n: $primitive) -> Self {
                use $crate::numbers::ChainRule as _;
                let (value, slope) = $crate::numbers::rules::powf(self.inner(), n);
                self.chain(value, slope)
            }
            #[inline]
            fn powd(&self, exponent: Self) -> Self {
                use $crate::numbers::ChainRule as _;
                let (value, along) = $crate::numbers::rules::powd(self.inner(), exponent.inner());
                self.chain2(exponent, value, along[0], along[1])
            }
            #[inline]
            fn log(&self, base: $primitive) -> Self {
                use $crate::numbers::ChainRule as _;
                let (value, slope) = $crate::numbers::rules::log(self.inner(), base);
                self.chain(value, slope)
            }
            #[inline]
            fn sin_cos(&self) -> (Self, Self) {
                use $crate::numbers::ChainRule as _;
                let (sin, cos) = self.inner().sin_cos();
                (self.chain(sin, cos), self.chain(cos, -sin))
            }
            #[inline]
            fn atan2(&self, other: Self) -> Self {
                use $crate::numbers::ChainRule as _;
                let (value, along) = $crate::numbers::rules::atan2(self.inner(), other.inner());
                self.chain2(other, value, along[0], along[1])
            }
        }
    };

    (@unary $($function:ident)+) => {
        $(#[inline]
        fn $function(&self) -> Self {
            use $crate::numbers::ChainRule as _;
            let (value, slope) = $crate::numbers::rules::$function(self.inner());
            self.chain(value, slope)
        })+
    };

    // The functions that `Scalar` adds and that are worth one step instead of many.
    (@scalar) => {
        dual_num_by_chain_rule!(@scalar softplus softplus_inverse sigmoid);
    };
    (@scalar $($function:ident)+) => {
        $(#[inline]
        fn $function(self) -> Self {
            use $crate::numbers::ChainRule as _;
            let (value, slope) = $crate::numbers::rules::$function(self.inner());
            self.chain(value, slope)
        })+
    };
}
