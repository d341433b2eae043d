//! The force network.
//!
//! ```text
//! "PAMN"  version u32 = 1  activation u32  bytes of a number u32 (4 or 8)  layers u32
//! activation's parameter f64  m f64  C f64  ν f64  r0 f64  L0 f64
//! inputs u32, outputs u32 of each layer
//! each layer: weights row by row, then biases
//! ```

use crate::activation::Activation;
use crate::joint::Joint;
use crate::real::Real;
use crate::{bytes, word};
use core::marker::PhantomData;

/// First bytes of a network.
pub const MAGIC: &[u8; 4] = b"PAMN";
/// Version of the format.
pub const VERSION: u32 = 1;
/// Where the shapes of the layers begin.
pub const SHAPES_AT: usize = 20 + 6 * 8;

/// Errors in the bytes of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NetworkError {
    /// They are no network.
    Magic,
    /// The format is another version's.
    Version,
    /// The numbers are of the other size; take the other [`Real`].
    Size,
    /// There is no activation of this number.
    Activation,
    /// The layers do not fit together, or it is no force of four inputs.
    Shape,
    /// The bytes end too early.
    Truncated,
}

impl core::fmt::Display for NetworkError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Magic => "these bytes are no network",
            Self::Version => "the network's format is another version's",
            Self::Size => "the network's numbers are of the other size",
            Self::Activation => "the network's activation is unknown",
            Self::Shape => "the network's layers do not fit together",
            Self::Truncated => "the network's bytes end too early",
        })
    }
}

impl core::error::Error for NetworkError {}

/// A network of `(m_f, m_e, x, ẋ)`, read in place.
#[derive(Debug, Clone, Copy)]
pub struct Network<'a, T> {
    bytes: &'a [u8],
    layers: usize,
    values_at: usize,
    width: usize,
    activation: Activation,
    joint: Joint,
    numbers: PhantomData<T>,
}

impl<'a, T: Real> Network<'a, T> {
    /// Checks the bytes and remembers where things lie.
    ///
    /// # Errors
    /// [`NetworkError`] if they are no network of such numbers.
    pub fn new(from: &'a [u8]) -> Result<Self, NetworkError> {
        use NetworkError::{Activation as Unknown, Magic, Shape, Size, Truncated, Version};
        if from.get(..4) != Some(MAGIC) {
            return Err(Magic);
        }
        let number = |at| word(from, at).ok_or(Truncated);
        let real = |k: usize| bytes(from, 20 + 8 * k).map(f64::from_le_bytes).ok_or(Truncated);
        if number(4)? != VERSION as usize {
            return Err(Version);
        }
        if number(12)? != T::SIZE {
            return Err(Size);
        }
        let activation = Activation::from_number(number(8)?, real(0)?).ok_or(Unknown)?;
        let layers = number(16)?;
        let (mut inputs, mut width, mut values) = (4, 0, 0_usize);
        for k in 0..layers {
            let outputs = number(SHAPES_AT + 8 * k + 4)?;
            if number(SHAPES_AT + 8 * k)? != inputs || outputs == 0 {
                return Err(Shape);
            }
            let row = inputs.checked_add(1).ok_or(Shape)?;
            let count = outputs.checked_mul(row).ok_or(Shape)?;
            values = values.checked_add(count).ok_or(Shape)?;
            (inputs, width) = (outputs, width.max(outputs));
        }
        if layers == 0 || inputs != 1 {
            return Err(Shape);
        }
        let values_at = SHAPES_AT + 8 * layers;
        let needed = values.checked_mul(T::SIZE).and_then(|n| n.checked_add(values_at));
        if needed.is_none_or(|n| from.len() < n) {
            return Err(Truncated);
        }
        let joint = Joint {
            mass_kg: real(1)?,
            gas_coefficient: real(2)?,
            deformation: real(3)?,
            radius_mm: real(4)?,
            length_mm: real(5)?,
        };
        Ok(Self { bytes: from, layers, values_at, width, activation, joint, numbers: PhantomData })
    }

    /// Mass, gas and geometry of the joint.
    #[must_use]
    pub fn joint(&self) -> &Joint {
        &self.joint
    }

    /// Numbers of scratch memory that an evaluation needs.
    #[must_use]
    pub fn work_len(&self) -> usize {
        2 * self.width
    }

    /// The restoring force (mN) at m_f, m_e (g), x (mm), ẋ (mm/s); none if `work` is shorter than
    /// [`work_len`](Self::work_len).
    pub fn force_mn(&self, input: [T; 4], work: &mut [T]) -> Option<T> {
        if work.len() < self.work_len() {
            return None;
        }
        let (mut now, mut next) = work[..2 * self.width].split_at_mut(self.width);
        let mut values = &self.bytes[self.values_at..];
        for k in 0..self.layers {
            let inputs = word(self.bytes, SHAPES_AT + 8 * k)?;
            let outputs = word(self.bytes, SHAPES_AT + 8 * k + 4)?;
            let source: &[T] = if k == 0 { &input } else { &now[..inputs] };
            for (j, out) in next[..outputs].iter_mut().enumerate() {
                let mut sum = T::read(values, outputs * inputs + j);
                for (i, &x) in source.iter().enumerate() {
                    sum = sum + T::read(values, j * inputs + i) * x;
                }
                *out = if k + 1 < self.layers { self.activation.value(sum) } else { sum };
            }
            values = &values[outputs * (inputs + 1) * T::SIZE..];
            core::mem::swap(&mut now, &mut next);
        }
        Some(now[0])
    }

    /// The stiffness estimate `[f(x+2h) + f(x+h) − f(x−h) − f(x−2h)] / 6h`, N/mm.
    pub fn stiffness_n_mm(&self, input: [T; 4], step_mm: T, work: &mut [T]) -> Option<T> {
        let mut sum = T::of(0.0);
        for (offset, sign) in [(2.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (-2.0, -1.0)] {
            let [m_f, m_e, x, v] = input;
            let force = self.force_mn([m_f, m_e, x + T::of(offset) * step_mm, v], work)?;
            sum = sum + T::of(sign) * force;
        }
        Some(sum / (T::of(6000.0) * step_mm))
    }
}
