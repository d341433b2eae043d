//! The numbers an evaluator computes with.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// `f32` or `f64`.
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Bytes of a number.
    const SIZE: usize;

    /// The number nearest to a double.
    fn of(value: f64) -> Self;

    /// The number as a double.
    fn widen(self) -> f64;

    /// Number `index` of a little-endian array; there must be enough bytes.
    fn read(bytes: &[u8], index: usize) -> Self;

    /// `eˣ`.
    fn exp(self) -> Self;

    /// `eˣ − 1`.
    fn exp_m1(self) -> Self;

    /// `ln(1 + x)`.
    fn ln_1p(self) -> Self;

    /// `tanh x`.
    fn tanh(self) -> Self;

    /// `sin x`.
    fn sin(self) -> Self;
}

macro_rules! real {
    ($float:ident, $size:literal, $exp:ident, $expm1:ident, $log1p:ident, $tanh:ident, $sin:ident) => {
        impl Real for $float {
            const SIZE: usize = $size;

            #[allow(clippy::cast_possible_truncation)]
            fn of(value: f64) -> Self {
                value as $float
            }
            fn widen(self) -> f64 {
                f64::from(self)
            }
            fn read(bytes: &[u8], index: usize) -> Self {
                let mut number = [0; $size];
                number.copy_from_slice(&bytes[index * $size..(index + 1) * $size]);
                $float::from_le_bytes(number)
            }
            fn exp(self) -> Self {
                libm::$exp(self)
            }
            fn exp_m1(self) -> Self {
                libm::$expm1(self)
            }
            fn ln_1p(self) -> Self {
                libm::$log1p(self)
            }
            fn tanh(self) -> Self {
                libm::$tanh(self)
            }
            fn sin(self) -> Self {
                libm::$sin(self)
            }
        }
    };
}

real!(f32, 4, expf, expm1f, log1pf, tanhf, sinf);
real!(f64, 8, exp, expm1, log1p, tanh, sin);
