//! Activations, by the numbers that files give them.

use crate::real::Real;

/// An activation with its parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Activation {
    /// `max(z, 0) + slope · min(z, 0)`.
    LeakyRelu(f64),
    /// `tanh z`.
    Tanh,
    /// `ln(1 + eᶻ)`.
    Softplus,
    /// `z / (1 + e⁻ᶻ)`.
    Silu,
    /// `½ z (1 + tanh(√(2/π) (z + 0.044715 z³)))`.
    Gelu,
    /// `z` for positive `z`, else `eᶻ − 1`.
    Elu,
    /// `sin z`.
    Sine,
}

impl Activation {
    /// The number that stands for it in a file.
    #[must_use]
    pub fn number(&self) -> u32 {
        match self {
            Self::LeakyRelu(_) => 0,
            Self::Tanh => 1,
            Self::Softplus => 2,
            Self::Silu => 3,
            Self::Gelu => 4,
            Self::Elu => 5,
            Self::Sine => 6,
        }
    }

    /// The activation of a number in a file.
    #[must_use]
    pub fn from_number(number: usize, parameter: f64) -> Option<Self> {
        Some(match number {
            0 => Self::LeakyRelu(parameter),
            1 => Self::Tanh,
            2 => Self::Softplus,
            3 => Self::Silu,
            4 => Self::Gelu,
            5 => Self::Elu,
            6 => Self::Sine,
            _ => return None,
        })
    }

    /// Its value.
    #[inline]
    pub fn value<T: Real>(&self, z: T) -> T {
        let (zero, one) = (T::of(0.0), T::of(1.0));
        match self {
            Self::LeakyRelu(slope) => {
                if z > zero {
                    z
                } else {
                    z * T::of(*slope)
                }
            }
            Self::Tanh => z.tanh(),
            Self::Softplus => {
                if z > zero {
                    z + (-z).exp().ln_1p()
                } else {
                    z.exp().ln_1p()
                }
            }
            Self::Silu => z / (one + (-z).exp()),
            Self::Gelu => {
                let inner = T::of(0.797_884_560_802_865_4) * (z + T::of(0.044_715) * z * z * z);
                T::of(0.5) * z * (one + inner.tanh())
            }
            Self::Elu => {
                if z > zero {
                    z
                } else {
                    z.exp_m1()
                }
            }
            Self::Sine => z.sin(),
        }
    }
}
