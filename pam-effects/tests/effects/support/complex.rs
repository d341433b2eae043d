//! Complex amplitudes of sinusoidal motion.

use std::f64::consts::TAU;
use std::ops::{Add, Div, Mul};

/// `re + j im`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Complex(pub(crate) f64, pub(crate) f64);

impl Complex {
    pub(crate) fn real(re: f64) -> Self {
        Self(re, 0.0)
    }

    /// `exp(j angle)`.
    pub(crate) fn turn(angle: f64) -> Self {
        Self(angle.cos(), angle.sin())
    }

    pub(crate) fn size(self) -> f64 {
        self.0.hypot(self.1)
    }

    /// `Im(self · exp(j ω t))`: the motion whose input is `sin ω t` times a real amplitude.
    pub(crate) fn at(self, rate_rad_s: f64, time_s: f64) -> f64 {
        (self * Self::turn(rate_rad_s * time_s)).1
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1)
    }
}

impl Mul for Complex {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0 - self.1 * o.1, self.0 * o.1 + self.1 * o.0)
    }
}

impl Div for Complex {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let square = o.0 * o.0 + o.1 * o.1;
        self * Self(o.0 / square, -o.1 / square)
    }
}

/// Fourier coefficient of a series at `hertz` over its last whole number of periods.
pub(crate) fn line(values: &[f64], step_s: f64, hertz: f64, periods: usize) -> Complex {
    let count = (periods as f64 / (hertz * step_s)).round() as usize;
    let from = values.len() - count;
    (from..values.len()).fold(Complex(0.0, 0.0), |sum, k| {
        let turn = Complex::turn(-TAU * hertz * step_s * k as f64);
        sum + Complex::real(values[k] * 2.0 / count as f64) * turn
    })
}
