//! The network on a batch, forwards.
//!
//! ```text
//! r = σ(W_ir x + b_ir + W_hr h + b_hr)      z = σ(W_iz x + b_iz + W_hz h + b_hz)
//! n = tanh(W_in x + b_in + r ⊙ (W_hn h + b_hn))        h' = (1 − z) ⊙ n + z ⊙ h
//! ŷ = W₂ tanh(W₁ h' + b₁) + b₂
//! ```
//!
//! (Cho et al. 2014 in the form of PyTorch, with the reset gate after the product.) Members of the batch are columns.

use super::parameters::{INPUTS, OUTPUTS, Shape};
use crate::batched::{Columns, multiply};
use crate::tanh::Tanh;
use pam_core::simd::gemm::Start;
use pam_core::simd::{Float, arch, math, padded};
use pulp::{Simd, WithSimd};

/// Weights of one recurrent layer in the layouts of its products, columns one after the other.
#[derive(Debug, Clone)]
pub(super) struct Layer<T> {
    pub(super) inputs: usize,
    /// `[2 hidden, inputs + hidden]`: reset and update gates over `[x; h]`.
    gates: Vec<T>,
    gates_bias: Vec<T>,
    /// `[hidden, inputs]` and `[hidden, hidden]`: the new state's own.
    new_input: Vec<T>,
    new_input_bias: Vec<T>,
    new_hidden: Vec<T>,
    new_hidden_bias: Vec<T>,
    /// `[padded inputs, 3 hidden]`: W_ihᵀ.
    pub(super) input_back: Vec<T>,
    /// `[hidden, 2 hidden]`: W_hrᵀ and W_hzᵀ.
    pub(super) gates_back: Vec<T>,
    /// `[hidden, hidden]`: W_hnᵀ.
    pub(super) new_back: Vec<T>,
}

/// Weights of the whole network in the layouts of its products.
#[derive(Debug, Clone)]
pub struct Network<T> {
    /// Sizes.
    pub shape: Shape,
    pub(super) layers: Vec<Layer<T>>,
    head: Vec<T>,
    head_bias: Vec<T>,
    out: Vec<T>,
    out_bias: Vec<T>,
    /// `[hidden, hidden]`: W₁ᵀ.
    pub(super) head_back: Vec<T>,
    /// `[hidden, 4]`: W₂ᵀ.
    pub(super) out_back: Vec<T>,
}

/// Rows of an output in a batch.
pub(super) const OUT_STRIDE: usize = 16;

/// A block of a row-major matrix `[.., columns]` as columns of `stride` numbers.
fn columns_of<T: Float>(
    w: &[f64],
    columns: usize,
    rows: std::ops::Range<usize>,
    stride: usize,
) -> Vec<T> {
    let mut out = vec![T::default(); columns * stride];
    for (i, row) in rows.enumerate() {
        for j in 0..columns {
            out[j * stride + i] = T::narrow(w[row * columns + j]);
        }
    }
    out
}

/// The transpose of such a block: its rows as columns of `stride` numbers.
fn rows_of<T: Float>(
    w: &[f64],
    columns: usize,
    rows: std::ops::Range<usize>,
    stride: usize,
) -> Vec<T> {
    let mut out = vec![T::default(); rows.len() * stride];
    for (column, row) in out.chunks_exact_mut(stride).zip(rows) {
        for (to, from) in column.iter_mut().zip(&w[row * columns..][..columns]) {
            *to = T::narrow(*from);
        }
    }
    out
}

fn narrow<T: Float>(values: impl Iterator<Item = f64>) -> Vec<T> {
    values.map(T::narrow).collect()
}

impl<T: Float> Network<T> {
    /// The network with these numbers, in the order of [`Shape::parts`].
    ///
    /// # Panics
    /// If their number does not fit the shape.
    #[must_use]
    pub fn new(shape: Shape, numbers: &[f64]) -> Self {
        let parts = shape.parts();
        assert_eq!(numbers.len(), shape.len());
        let part = |k: usize| &numbers[parts[k].range.clone()];
        let h = shape.hidden;
        let layers = (0..shape.layers)
            .map(|l| {
                let inputs = shape.inputs(l);
                let (wi, wh, bi, bh) =
                    (part(4 * l), part(4 * l + 1), part(4 * l + 2), part(4 * l + 3));
                let mut gates = columns_of(wi, inputs, 0..2 * h, 2 * h);
                gates.extend(columns_of::<T>(wh, h, 0..2 * h, 2 * h));
                Layer {
                    inputs,
                    gates,
                    gates_bias: narrow(bi[..2 * h].iter().zip(bh).map(|(a, b)| a + b)),
                    new_input: columns_of(wi, inputs, 2 * h..3 * h, h),
                    new_input_bias: narrow(bi[2 * h..].iter().copied()),
                    new_hidden: columns_of(wh, h, 2 * h..3 * h, h),
                    new_hidden_bias: narrow(bh[2 * h..].iter().copied()),
                    input_back: rows_of(wi, inputs, 0..3 * h, padded(inputs)),
                    gates_back: rows_of(wh, h, 0..2 * h, h),
                    new_back: rows_of(wh, h, 2 * h..3 * h, h),
                }
            })
            .collect();
        let at = 4 * shape.layers;
        let mut out_bias = narrow(part(at + 3).iter().copied());
        out_bias.resize(OUT_STRIDE, T::default());
        Self {
            shape,
            layers,
            head: columns_of(part(at), h, 0..h, h),
            head_bias: narrow(part(at + 1).iter().copied()),
            out: columns_of(part(at + 2), h, 0..OUTPUTS, OUT_STRIDE),
            out_bias,
            head_back: rows_of(part(at), h, 0..h, h),
            out_back: rows_of(part(at + 2), h, 0..OUTPUTS, h),
        }
    }

    /// One recurrent layer: from `stack` `[x; h]` to the new hidden state, keeping the gates.
    pub(super) fn layer_forward(
        &self,
        l: usize,
        members: usize,
        stack: &[T],
        keep: LayerStep<'_, T>,
    ) {
        let (layer, h) = (&self.layers[l], self.shape.hidden);
        let stride = layer.inputs + h;
        let LayerStep { gates, new, new_hidden, hidden } = keep;
        let inputs = layer.inputs;
        let all = Columns::of(stack, members, stride);
        multiply([2 * h, stride], &layer.gates, all, Start::Columns(&layer.gates_bias), gates);
        let bias = Start::Columns(&layer.new_input_bias);
        multiply([h, inputs], &layer.new_input, all, bias, new);
        let before = Columns::of(&stack[inputs..], members, stride);
        let bias = Start::Columns(&layer.new_hidden_bias);
        multiply([h, h], &layer.new_hidden, before, bias, new_hidden);
        arch().dispatch(Gates {
            h,
            inputs: layer.inputs,
            members,
            stack,
            gates,
            new,
            new_hidden,
            hidden,
        });
    }

    /// The head: from hidden states to outputs, keeping `tanh(W₁ h + b₁)`.
    pub(super) fn head_forward(
        &self,
        members: usize,
        hidden: &[T],
        inner: &mut [T],
        out: &mut [T],
    ) {
        let h = self.shape.hidden;
        let bias = Start::Columns(&self.head_bias);
        multiply([h, h], &self.head, Columns::of(hidden, members, h), bias, inner);
        arch().dispatch(Tanh { z: &mut *inner });
        let bias = Start::Columns(&self.out_bias);
        multiply([OUT_STRIDE, h], &self.out, Columns::of(inner, members, h), bias, out);
    }
}

/// Values that one layer keeps from one step; `hidden` is the new state `[members][hidden]`.
pub(super) struct LayerStep<'a, T> {
    pub(super) gates: &'a mut [T],
    pub(super) new: &'a mut [T],
    pub(super) new_hidden: &'a mut [T],
    pub(super) hidden: &'a mut [T],
}

/// Gates and new state from their sums.
struct Gates<'a, T> {
    h: usize,
    inputs: usize,
    members: usize,
    stack: &'a [T],
    gates: &'a mut [T],
    new: &'a mut [T],
    new_hidden: &'a [T],
    hidden: &'a mut [T],
}

impl<T: Float> WithSimd for Gates<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let h = self.h;
        for g in &mut self.gates[..2 * h * self.members] {
            *g = math::sigmoid(*g);
        }
        for member in 0..self.members {
            let (r, z) = self.gates[member * 2 * h..][..2 * h].split_at(h);
            let new = &mut self.new[member * h..][..h];
            let new_hidden = &self.new_hidden[member * h..][..h];
            let old = &self.stack[member * (self.inputs + h) + self.inputs..][..h];
            let to = &mut self.hidden[member * h..][..h];
            for i in 0..h {
                let n = math::tanh(r[i].fma(new_hidden[i], new[i]));
                new[i] = n;
                to[i] = z[i].fma(old[i] - n, n);
            }
        }
    }
}

/// Hidden states of a batch in operation, without anything kept for a gradient.
#[derive(Debug, Clone)]
pub struct Running<T> {
    members: usize,
    /// `[x; h]` of each layer.
    stacks: Vec<Vec<T>>,
    gates: Vec<T>,
    new: Vec<T>,
    new_hidden: Vec<T>,
    hidden: Vec<T>,
    inner: Vec<T>,
    out: Vec<T>,
}

impl<T: Float> Running<T> {
    /// A batch with hidden states of zero.
    #[must_use]
    pub fn new(network: &Network<T>, members: usize) -> Self {
        let h = network.shape.hidden;
        let zeros = |n: usize| vec![T::default(); n * members];
        Self {
            members,
            stacks: network.layers.iter().map(|l| zeros(l.inputs + h)).collect(),
            gates: zeros(2 * h),
            new: zeros(h),
            new_hidden: zeros(h),
            hidden: zeros(h),
            inner: zeros(h),
            out: zeros(OUT_STRIDE),
        }
    }

    /// Feeds one scaled input a member; hidden states go on.
    pub fn feed(&mut self, network: &Network<T>, inputs: &[[T; INPUTS]]) {
        let h = network.shape.hidden;
        let stride = INPUTS + h;
        for (column, input) in self.stacks[0].chunks_exact_mut(stride).zip(inputs) {
            column[..INPUTS].copy_from_slice(input);
        }
        for l in 0..network.layers.len() {
            let (before, after) = self.stacks.split_at_mut(l + 1);
            let keep = LayerStep {
                gates: &mut self.gates,
                new: &mut self.new,
                new_hidden: &mut self.new_hidden,
                hidden: &mut self.hidden,
            };
            network.layer_forward(l, self.members, &before[l], keep);
            let own = network.layers[l].inputs;
            for (member, hidden) in self.hidden.chunks_exact(h).enumerate() {
                before[l][member * (own + h) + own..][..h].copy_from_slice(hidden);
                if let Some(next) = after.first_mut() {
                    next[member * 2 * h..][..h].copy_from_slice(hidden);
                }
            }
        }
    }

    /// The scaled next state of each member, from the hidden states.
    pub fn read(&mut self, network: &Network<T>, outputs: &mut [[T; OUTPUTS]]) {
        network.head_forward(self.members, &self.hidden, &mut self.inner, &mut self.out);
        for (to, column) in outputs.iter_mut().zip(self.out.chunks_exact(OUT_STRIDE)) {
            to.copy_from_slice(&column[..OUTPUTS]);
        }
    }
}
