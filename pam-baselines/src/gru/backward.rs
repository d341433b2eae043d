//! The exact gradient of a block of windows: back-propagation through all of its steps.

use super::network::{Network, OUT_STRIDE};
use super::parameters::OUTPUTS;
use super::tape::Tape;
use crate::batched::{Columns, multiply, row_sums, weight_gradient};
use crate::tanh::TanhBack;
use pam_core::simd::gemm::Start;
use pam_core::simd::{Float, arch, padded};
use pulp::{Simd, WithSimd};

impl<T: Float> Tape<T> {
    /// Cotangents of all sums, from those of the outputs.
    pub(super) fn backward(&mut self, network: &Network<T>, n: usize) {
        let h = network.shape.hidden;
        for tape in &mut self.layers {
            tape.carried[..n * h].fill(T::default());
        }
        let count = network.layers.len();
        for t in (0..self.steps()).rev() {
            if let Some(k) = (t + 1).checked_sub(self.known) {
                let block = k * n * h..(k + 1) * n * h;
                let out = &self.out[k * n * OUT_STRIDE..];
                let back = &mut self.head_back[block.clone()];
                let out = Columns::of(out, n, OUT_STRIDE);
                multiply([h, OUTPUTS], &network.out_back, out, Start::Zero, back);
                arch().dispatch(TanhBack { values: &self.head_inner[block], cotangents: back });
                let carried = &mut self.layers[count - 1].carried;
                let back = Columns::of(back, n, h);
                multiply([h, h], &network.head_back, back, Start::Held, carried);
            }
            for l in (0..count).rev() {
                let layer = &network.layers[l];
                let (below, own) = self.layers.split_at_mut(l);
                let tape = &mut own[0];
                let back = &mut tape.back[t * n * 4 * h..][..n * 4 * h];
                arch().dispatch(GatesBack {
                    h,
                    inputs: layer.inputs,
                    members: n,
                    stack: &tape.stack[t * n * (layer.inputs + h)..],
                    gates: &tape.gates[t * n * 2 * h..],
                    new: &tape.new[t * n * h..],
                    new_hidden: &tape.new_hidden[t * n * h..],
                    carried: &mut tape.carried,
                    back: &mut *back,
                });
                let carried = &mut tape.carried;
                let all = Columns::of(back, n, 4 * h);
                multiply([h, 2 * h], &layer.gates_back, all, Start::Held, carried);
                let last = Columns::of(&back[3 * h..], n, 4 * h);
                multiply([h, h], &layer.new_back, last, Start::Held, carried);
                // Cotangents of the input: of the layer below, or of an output that was fed back.
                let rows = padded(layer.inputs);
                if let Some(below) = below.last_mut() {
                    let to = &mut below.carried;
                    multiply([rows, 3 * h], &layer.input_back, all, Start::Held, to);
                } else if let Some(k) = t.checked_sub(self.known) {
                    let to = &mut self.input_back;
                    multiply([rows, 3 * h], &layer.input_back, all, Start::Zero, to);
                    for member in 0..n {
                        let out = &mut self.out[(k * n + member) * OUT_STRIDE..][..OUTPUTS];
                        for (o, b) in out.iter_mut().zip(&self.input_back[member * rows..]) {
                            *o += *b;
                        }
                    }
                }
            }
        }
    }

    /// Adds the gradient of the weights: products of cotangents with what they multiplied, over all steps
    /// and members at once.
    pub(super) fn collect(&mut self, network: &Network<T>, n: usize, gradient: &mut [f64]) {
        let h = network.shape.hidden;
        let parts = network.shape.parts();
        let steps = self.steps();
        for (l, (tape, layer)) in self.layers.iter_mut().zip(&network.layers).enumerate() {
            let stride = layer.inputs + h;
            let read = Columns { values: &tape.stack, count: steps * n, stride };
            weight_gradient([4 * h, stride], &tape.back, read, &mut tape.sums);
            let bias = row_sums(&tape.back[..steps * n * 4 * h], 4 * h);
            for row in 0..3 * h {
                // The hidden state enters the new state's sum behind the reset gate.
                let hidden_row = if row < 2 * h { row } else { row + h };
                let input = &mut gradient[parts[4 * l].range.clone()][row * layer.inputs..];
                for (j, g) in input[..layer.inputs].iter_mut().enumerate() {
                    *g += tape.sums[j * 4 * h + row].widen();
                }
                let hidden = &mut gradient[parts[4 * l + 1].range.clone()][row * h..];
                for (j, g) in hidden[..h].iter_mut().enumerate() {
                    *g += tape.sums[(layer.inputs + j) * 4 * h + hidden_row].widen();
                }
                gradient[parts[4 * l + 2].range.start + row] += bias[row];
                gradient[parts[4 * l + 3].range.start + row] += bias[hidden_row];
            }
        }
        let at = 4 * network.layers.len();
        let columns = self.horizon * n;
        let mut head = |weights: usize, rows: usize, stride: usize, back: &[T], values: &[T]| {
            let mut sums = vec![T::default(); h * stride];
            let read = Columns { values, count: columns, stride: h };
            weight_gradient([stride, h], back, read, &mut sums);
            let bias = row_sums(&back[..columns * stride], stride);
            for row in 0..rows {
                let to = &mut gradient[parts[weights].range.clone()][row * h..];
                for (j, g) in to[..h].iter_mut().enumerate() {
                    *g += sums[j * stride + row].widen();
                }
                gradient[parts[weights + 1].range.start + row] += bias[row];
            }
        };
        head(at, h, h, &self.head_back, &self.head_in);
        // Rows past the four outputs hold what the padding of the products left there: zeros.
        head(at + 2, OUTPUTS, OUT_STRIDE, &self.out, &self.head_inner);
    }
}

/// Cotangents of the sums of one step from that of its hidden state, which becomes the direct part of the
/// cotangent of the hidden state before.
struct GatesBack<'a, T> {
    h: usize,
    inputs: usize,
    members: usize,
    stack: &'a [T],
    gates: &'a [T],
    new: &'a [T],
    new_hidden: &'a [T],
    carried: &'a mut [T],
    back: &'a mut [T],
}

impl<T: Float> WithSimd for GatesBack<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let h = self.h;
        let one = T::narrow(1.0);
        for member in 0..self.members {
            let (r, z) = self.gates[member * 2 * h..][..2 * h].split_at(h);
            let new = &self.new[member * h..][..h];
            let new_hidden = &self.new_hidden[member * h..][..h];
            let old = &self.stack[member * (self.inputs + h) + self.inputs..][..h];
            let carried = &mut self.carried[member * h..][..h];
            let (gates_back, rest) = self.back[member * 4 * h..][..4 * h].split_at_mut(2 * h);
            let (r_back, z_back) = gates_back.split_at_mut(h);
            let (new_back, hidden_back) = rest.split_at_mut(h);
            for i in 0..h {
                let c = carried[i];
                let by_new = c * (one - z[i]) * (one - new[i] * new[i]);
                new_back[i] = by_new;
                hidden_back[i] = by_new * r[i];
                r_back[i] = by_new * new_hidden[i] * r[i] * (one - r[i]);
                z_back[i] = c * (old[i] - new[i]) * z[i] * (one - z[i]);
                carried[i] = c * z[i];
            }
        }
    }
}
