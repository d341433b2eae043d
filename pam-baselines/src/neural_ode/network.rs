//! The field on a batch, and its pull-back.
//!
//! ```text
//! ż = s ⊙ (W₃ tanh(W₂ tanh(W₁ [z; u] + b₁) + b₂) + b₃)
//! ```
//!
//! with the scaled state z, the scaled force u, and rates s that give the network outputs of order one.

use crate::batched::{Columns, multiply, row_sums, weight_gradient};
use crate::tanh::{Tanh, TanhBack};
use pam_core::simd::gemm::Start;
use pam_core::simd::{Float, arch};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// States.
pub const STATES: usize = 4;
/// Rows of inputs (state and force) and outputs in a batch.
pub(super) const STRIDE: usize = 16;
/// Inputs of the network.
const INPUTS: usize = STATES + 1;

/// Arrays of a network of this width: inputs and outputs of its three layers.
fn layers(width: usize) -> [(usize, usize); 3] {
    [(INPUTS, width), (width, width), (width, STATES)]
}

/// Number of weights and biases.
#[must_use]
pub fn parameter_len(width: usize) -> usize {
    layers(width).iter().map(|(i, o)| (i + 1) * o).sum()
}

/// Random weights, uniform within `±1/√inputs`; the last layer's are a tenth of that, so that the first
/// motions are slow.
#[must_use]
pub fn random(width: usize, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut all = Vec::with_capacity(parameter_len(width));
    for (k, (inputs, outputs)) in layers(width).into_iter().enumerate() {
        let bound = if k == 2 { 0.1 } else { 1.0 } / (inputs as f64).sqrt();
        all.extend((0..(inputs + 1) * outputs).map(|_| random.random_range(-bound..bound)));
    }
    all
}

/// Weights in the layouts of the products. All numbers stand layer by layer: W row by row, then b.
#[derive(Debug, Clone)]
pub struct Field<T> {
    /// Width of both hidden layers, a multiple of 16.
    pub width: usize,
    forward: [Vec<T>; 3],
    bias: [Vec<T>; 3],
    /// Transposes.
    back: [Vec<T>; 3],
    rates: [T; STATES],
}

impl<T: Float> Field<T> {
    /// The field with these numbers and rates (1/s).
    ///
    /// # Panics
    /// If their number does not fit the width.
    #[must_use]
    pub fn new(width: usize, numbers: &[f64], rates: [f64; STATES]) -> Self {
        assert_eq!(numbers.len(), parameter_len(width));
        let mut at = 0;
        let mut forward: [Vec<T>; 3] = Default::default();
        let mut bias: [Vec<T>; 3] = Default::default();
        let mut back: [Vec<T>; 3] = Default::default();
        for (k, (inputs, outputs)) in layers(width).into_iter().enumerate() {
            let w = &numbers[at..at + inputs * outputs];
            let b = &numbers[at + inputs * outputs..][..outputs];
            at += (inputs + 1) * outputs;
            let (rows, columns) =
                (outputs.next_multiple_of(STRIDE), inputs.next_multiple_of(STRIDE));
            forward[k] = vec![T::default(); rows * inputs];
            back[k] = vec![T::default(); columns * outputs];
            for o in 0..outputs {
                for i in 0..inputs {
                    let value = T::narrow(w[o * inputs + i]);
                    forward[k][i * rows + o] = value;
                    back[k][o * columns + i] = value;
                }
            }
            bias[k] = b.iter().map(|v| T::narrow(*v)).collect();
            bias[k].resize(rows, T::default());
        }
        Self { width, forward, bias, back, rates: rates.map(T::narrow) }
    }

    /// Rates of the states of the batch: `inputs` `[members][16]` holds `[z; u]`, `rates` `[members][16]` gets
    /// ż; both hidden layers are kept.
    pub(super) fn eval(&self, members: usize, inputs: &[T], keep: [&mut [T]; 2], rates: &mut [T]) {
        let w = self.width;
        let [first, second] = keep;
        let [w1, w2, w3] = &self.forward;
        let [b1, b2, b3] = self.bias.each_ref().map(|b| Start::Columns(b));
        multiply([w, INPUTS], w1, Columns::of(inputs, members, STRIDE), b1, first);
        arch().dispatch(Tanh { z: &mut first[..members * w] });
        multiply([w, w], w2, Columns::of(first, members, w), b2, second);
        arch().dispatch(Tanh { z: &mut second[..members * w] });
        multiply([STRIDE, w], w3, Columns::of(second, members, w), b3, rates);
        for column in rates[..members * STRIDE].chunks_exact_mut(STRIDE) {
            for (v, s) in column.iter_mut().zip(self.rates) {
                *v *= s;
            }
        }
    }

    /// The pull-back at one evaluation. `outs` `[members][16]` holds the cotangents of ż and gets those of the
    /// last layer's sums; `hidden` gets those of the sums of both hidden layers; `inputs` `[members][16]` those
    /// of `[z; u]`.
    pub(super) fn pull_back(
        &self,
        members: usize,
        kept: [&[T]; 2],
        outs: &mut [T],
        hidden: [&mut [T]; 2],
        inputs: &mut [T],
    ) {
        let w = self.width;
        for column in outs[..members * STRIDE].chunks_exact_mut(STRIDE) {
            for (v, s) in column.iter_mut().zip(self.rates) {
                *v *= s;
            }
        }
        let [first, second] = hidden;
        let [w1, w2, w3] = &self.back;
        multiply([w, STATES], w3, Columns::of(outs, members, STRIDE), Start::Zero, second);
        arch().dispatch(TanhBack { values: &kept[1][..members * w], cotangents: second });
        multiply([w, w], w2, Columns::of(second, members, w), Start::Zero, first);
        arch().dispatch(TanhBack { values: &kept[0][..members * w], cotangents: first });
        multiply([STRIDE, w], w1, Columns::of(first, members, w), Start::Zero, inputs);
    }

    /// Adds the gradient of all numbers from the cotangents of the sums and what they multiplied, over
    /// `columns` evaluations times members.
    pub(super) fn collect(
        &self,
        columns: usize,
        inputs: &[T],
        kept: [&[T]; 2],
        sums: [&[T]; 3],
        gradient: &mut [f64],
    ) {
        let w = self.width;
        let values = [(inputs, STRIDE), (kept[0], w), (kept[1], w)];
        let mut at = 0;
        for (k, (ins, outs)) in layers(w).into_iter().enumerate() {
            let rows = outs.next_multiple_of(STRIDE);
            let (values, stride) = values[k];
            let mut c = vec![T::default(); rows * ins];
            let read = Columns { values, count: columns, stride };
            weight_gradient([rows, ins], sums[k], read, &mut c);
            for o in 0..outs {
                for i in 0..ins {
                    gradient[at + o * ins + i] += c[i * rows + o].widen();
                }
            }
            at += ins * outs;
            let bias = row_sums(&sums[k][..columns * rows], rows);
            for (g, b) in gradient[at..at + outs].iter_mut().zip(bias) {
                *g += b;
            }
            at += outs;
        }
    }
}
