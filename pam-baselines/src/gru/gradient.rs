//! Loss of windows and its exact gradient: back-propagation through all steps of warm-up and recursion.

use super::network::{LayerStep, Network, OUT_STRIDE};
use super::parameters::{INPUTS, OUTPUTS};
use crate::tanh::TanhBack;
use pam_core::simd::gemm::{Finish, Layout, Product, Start};
use pam_core::simd::{Float, arch, padded};
use pulp::{Simd, WithSimd};

/// Weights of the squared errors of x, ẋ, P_f and P_e.
pub const LOSS_WEIGHTS: [f64; OUTPUTS] = [100.0, 100.0, 1.0, 1.0];

/// Scaled samples of one window: `warm_up` measured ones, then those that are predicted.
#[derive(Debug, Clone, Copy)]
pub struct Window<'a, T> {
    /// State and force of each sample, `warm_up + horizon` of them.
    pub samples: &'a [[T; INPUTS]],
}

/// Memory for loss and gradient of a block of windows.
#[derive(Debug)]
pub struct Tape<T> {
    lanes: usize,
    warm_up: usize,
    horizon: usize,
    layers: Vec<LayerTape<T>>,
    /// `[horizon][lanes][hidden]`: hidden states that the head read, and what it made of them.
    head_in: Vec<T>,
    head_inner: Vec<T>,
    /// `[horizon][lanes][16]`: outputs, later their cotangents.
    out: Vec<T>,
    /// Cotangents of the head.
    head_back: Vec<T>,
    /// Cotangents of a layer's input.
    input_back: Vec<T>,
    hidden: Vec<T>,
}

/// What one layer keeps of all steps, and its cotangents.
#[derive(Debug)]
struct LayerTape<T> {
    /// `[steps + 1][lanes][inputs + hidden]`.
    stack: Vec<T>,
    /// `[steps][lanes][2 hidden]`.
    gates: Vec<T>,
    /// `[steps][lanes][hidden]`.
    new: Vec<T>,
    new_hidden: Vec<T>,
    /// `[steps][lanes][4 hidden]`: cotangents of the sums of reset, update, new, and of `W_hn h + b_hn`.
    back: Vec<T>,
    /// `[lanes][hidden]`: cotangent of the hidden state that goes on.
    carried: Vec<T>,
    /// `[inputs + hidden][4 hidden]`: the gradient of the weights.
    sums: Vec<T>,
}

impl<T: Float> Tape<T> {
    /// Memory for blocks of up to `lanes` windows.
    #[must_use]
    pub fn new(network: &Network<T>, lanes: usize, warm_up: usize, horizon: usize) -> Self {
        let h = network.shape.hidden;
        let steps = warm_up + horizon - 1;
        let zeros = |n: usize| vec![T::default(); n];
        let layers = network
            .layers
            .iter()
            .map(|l| LayerTape {
                stack: zeros((steps + 1) * lanes * (l.inputs + h)),
                gates: zeros(steps * lanes * 2 * h),
                new: zeros(steps * lanes * h),
                new_hidden: zeros(steps * lanes * h),
                back: zeros(steps * lanes * 4 * h),
                carried: zeros(lanes * h),
                sums: zeros((l.inputs + h) * 4 * h),
            })
            .collect();
        Self {
            lanes,
            warm_up,
            horizon,
            layers,
            head_in: zeros(horizon * lanes * h),
            head_inner: zeros(horizon * lanes * h),
            out: zeros(horizon * lanes * OUT_STRIDE),
            head_back: zeros(horizon * lanes * h),
            input_back: zeros(lanes * h.max(padded(INPUTS))),
            hidden: zeros(lanes * h),
        }
    }

    /// Sum of squared weighted errors over windows and predicted samples, and with `gradient` its exact
    /// gradient, added there in the order of [`Shape::parts`](super::Shape::parts).
    ///
    /// # Panics
    /// If there are more windows than lanes, or a window is too short.
    pub fn run(
        &mut self,
        network: &Network<T>,
        windows: &[Window<'_, T>],
        gradient: Option<&mut [f64]>,
    ) -> f64 {
        let n = windows.len();
        assert!(n <= self.lanes, "more windows than lanes");
        let loss = self.forward(network, windows);
        if let Some(gradient) = gradient {
            self.backward(network, n);
            self.collect(network, n, gradient);
        }
        loss
    }

    fn steps(&self) -> usize {
        self.warm_up + self.horizon - 1
    }

    /// Predicts and leaves the cotangents of the outputs in `out`.
    fn forward(&mut self, network: &Network<T>, windows: &[Window<'_, T>]) -> f64 {
        let (n, h) = (windows.len(), network.shape.hidden);
        let count = network.layers.len();
        for (tape, layer) in self.layers.iter_mut().zip(&network.layers) {
            let stride = layer.inputs + h;
            for column in tape.stack[..n * stride].chunks_exact_mut(stride) {
                column[layer.inputs..].fill(T::default());
            }
        }
        let mut loss = 0.0;
        for t in 0..self.steps() {
            let block = t * n * (INPUTS + h);
            for (lane, window) in windows.iter().enumerate() {
                let to = &mut self.layers[0].stack[block + lane * (INPUTS + h)..][..INPUTS];
                to.copy_from_slice(&window.samples[t]);
                if let Some(k) = t.checked_sub(self.warm_up) {
                    let predicted = &self.out[(k * n + lane) * OUT_STRIDE..][..OUTPUTS];
                    to[..OUTPUTS].copy_from_slice(predicted);
                }
            }
            for l in 0..count {
                let stride = network.layers[l].inputs + h;
                let (own, above) = self.layers.split_at_mut(l + 1);
                let tape = &mut own[l];
                let (now, next) = tape.stack.split_at_mut((t + 1) * n * stride);
                let keep = LayerStep {
                    gates: &mut tape.gates[t * n * 2 * h..],
                    new: &mut tape.new[t * n * h..],
                    new_hidden: &mut tape.new_hidden[t * n * h..],
                    hidden: &mut self.hidden,
                };
                network.layer_forward(l, n, &now[t * n * stride..], keep);
                for (lane, hidden) in self.hidden[..n * h].chunks_exact(h).enumerate() {
                    next[lane * stride + stride - h..][..h].copy_from_slice(hidden);
                    if let Some(above) = above.first_mut() {
                        above.stack[(t * n + lane) * 2 * h..][..h].copy_from_slice(hidden);
                    }
                }
            }
            let Some(k) = (t + 1).checked_sub(self.warm_up) else { continue };
            let kept = k * n * h..(k + 1) * n * h;
            self.head_in[kept.clone()].copy_from_slice(&self.hidden[..n * h]);
            let out = &mut self.out[k * n * OUT_STRIDE..];
            network.head_forward(n, &self.hidden, &mut self.head_inner[kept], out);
        }
        // Errors become cotangents only now: predictions were inputs until here.
        for (k, block) in
            self.out[..self.horizon * n * OUT_STRIDE].chunks_exact_mut(n * OUT_STRIDE).enumerate()
        {
            for (column, window) in block.chunks_exact_mut(OUT_STRIDE).zip(windows) {
                let measured = &window.samples[self.warm_up + k];
                for c in 0..OUTPUTS {
                    let error = column[c] - measured[c];
                    loss += LOSS_WEIGHTS[c] * error.widen() * error.widen();
                    column[c] = error * T::narrow(2.0 * LOSS_WEIGHTS[c]);
                }
            }
        }
        loss
    }

    fn backward(&mut self, network: &Network<T>, n: usize) {
        let h = network.shape.hidden;
        for tape in &mut self.layers {
            tape.carried[..n * h].fill(T::default());
        }
        let count = network.layers.len();
        for t in (0..self.steps()).rev() {
            if let Some(k) = (t + 1).checked_sub(self.warm_up) {
                let block = k * n * h..(k + 1) * n * h;
                let out = &self.out[k * n * OUT_STRIDE..];
                let back = &mut self.head_back[block.clone()];
                multiply(n, h, OUTPUTS, &network.out_back, out, OUT_STRIDE, Start::Zero, back);
                arch().dispatch(TanhBack { values: &self.head_inner[block], cotangents: back });
                let carried = &mut self.layers[count - 1].carried;
                multiply(n, h, h, &network.head_back, back, h, Start::Held, carried);
            }
            for l in (0..count).rev() {
                let layer = &network.layers[l];
                let (below, own) = self.layers.split_at_mut(l);
                let tape = &mut own[0];
                let back = &mut tape.back[t * n * 4 * h..][..n * 4 * h];
                arch().dispatch(GatesBack {
                    h,
                    inputs: layer.inputs,
                    lanes: n,
                    stack: &tape.stack[t * n * (layer.inputs + h)..],
                    gates: &tape.gates[t * n * 2 * h..],
                    new: &tape.new[t * n * h..],
                    new_hidden: &tape.new_hidden[t * n * h..],
                    carried: &mut tape.carried,
                    back: &mut *back,
                });
                let carried = &mut tape.carried;
                multiply(n, h, 2 * h, &layer.gates_back, back, 4 * h, Start::Held, carried);
                let last = &back[3 * h..];
                multiply(n, h, h, &layer.new_back, last, 4 * h, Start::Held, carried);
                // What reaches the input: the layer below, or an output that was fed back.
                let rows = padded(layer.inputs);
                if let Some(below) = below.last_mut() {
                    let to = &mut below.carried;
                    multiply(n, rows, 3 * h, &layer.input_back, back, 4 * h, Start::Held, to);
                } else if let Some(k) = t.checked_sub(self.warm_up) {
                    let to = &mut self.input_back;
                    multiply(n, rows, 3 * h, &layer.input_back, back, 4 * h, Start::Zero, to);
                    for lane in 0..n {
                        let out = &mut self.out[(k * n + lane) * OUT_STRIDE..][..OUTPUTS];
                        for (o, b) in out.iter_mut().zip(&self.input_back[lane * rows..]) {
                            *o += *b;
                        }
                    }
                }
            }
        }
    }

    /// Adds the gradient of the weights: products of cotangents with what they multiplied, over all steps
    /// and lanes at once.
    fn collect(&mut self, network: &Network<T>, n: usize, gradient: &mut [f64]) {
        let h = network.shape.hidden;
        let parts = network.shape.parts();
        let steps = self.steps();
        for (l, (tape, layer)) in self.layers.iter_mut().zip(&network.layers).enumerate() {
            let stride = layer.inputs + h;
            Product {
                rows: 4 * h,
                inner: steps * n,
                columns: stride,
                a: &tape.back,
                b: &tape.stack,
                layout: Layout::Rows,
                b_stride: stride,
                start: Start::Zero,
                finish: Finish::Store,
                c: &mut tape.sums,
            }
            .run();
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
            Product {
                rows: stride,
                inner: columns,
                columns: h,
                a: back,
                b: values,
                layout: Layout::Rows,
                b_stride: h,
                start: Start::Zero,
                finish: Finish::Store,
                c: &mut sums,
            }
            .run();
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

/// Sums of columns of `stride` numbers, row by row.
fn row_sums<T: Float>(columns: &[T], stride: usize) -> Vec<f64> {
    let mut sums = vec![0.0; stride];
    for column in columns.chunks_exact(stride) {
        for (s, v) in sums.iter_mut().zip(column) {
            *s += v.widen();
        }
    }
    sums
}

#[allow(clippy::too_many_arguments)]
fn multiply<T: Float>(
    columns: usize,
    rows: usize,
    inner: usize,
    a: &[T],
    b: &[T],
    b_stride: usize,
    start: Start<'_, T>,
    c: &mut [T],
) {
    let (layout, finish) = (Layout::Columns, Finish::Store);
    Product { rows, inner, columns, a, b, layout, b_stride, start, finish, c }.run();
}

/// Cotangents of the sums of one step from that of its hidden state, which becomes the direct part of the
/// cotangent of the hidden state before.
struct GatesBack<'a, T> {
    h: usize,
    inputs: usize,
    lanes: usize,
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
        for lane in 0..self.lanes {
            let (r, z) = self.gates[lane * 2 * h..][..2 * h].split_at(h);
            let new = &self.new[lane * h..][..h];
            let new_hidden = &self.new_hidden[lane * h..][..h];
            let old = &self.stack[lane * (self.inputs + h) + self.inputs..][..h];
            let carried = &mut self.carried[lane * h..][..h];
            let (gates_back, rest) = self.back[lane * 4 * h..][..4 * h].split_at_mut(2 * h);
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

#[cfg(test)]
mod tests {
    use super::super::parameters::Shape;
    use super::*;

    fn samples(lanes: usize, len: usize) -> Vec<Vec<[f64; INPUTS]>> {
        (0..lanes)
            .map(|lane| {
                (0..len)
                    .map(|t| {
                        std::array::from_fn(|c| {
                            (0.31 * t as f64 + 0.7 * lane as f64 + 1.3 * c as f64).sin()
                        })
                    })
                    .collect()
            })
            .collect()
    }

    /// The gradient against central differences of the loss in double precision, in every array.
    #[test]
    fn the_gradient_is_that_of_the_loss() {
        let shape = Shape { hidden: 16, layers: 2 };
        let (warm_up, horizon) = (4, 5);
        let numbers = shape.random(3);
        let data = samples(3, warm_up + horizon);
        let windows: Vec<Window<'_, f64>> = data.iter().map(|s| Window { samples: s }).collect();
        let loss = |numbers: &[f64]| {
            let network = Network::<f64>::new(shape, numbers);
            Tape::new(&network, 3, warm_up, horizon).run(&network, &windows, None)
        };
        let network = Network::<f64>::new(shape, &numbers);
        let mut gradient = vec![0.0; shape.len()];
        let value =
            Tape::new(&network, 3, warm_up, horizon).run(&network, &windows, Some(&mut gradient));
        assert_eq!(value, loss(&numbers));
        for part in shape.parts() {
            for k in [0, part.range.len() / 3, part.range.len() / 2, part.range.len() - 1] {
                let at = part.range.start + k;
                let h = 1e-5;
                let mut up = numbers.clone();
                up[at] += h;
                let mut down = numbers.clone();
                down[at] -= h;
                let difference = (loss(&up) - loss(&down)) / (2.0 * h);
                let scale = difference.abs().max(1e-2);
                assert!(
                    (gradient[at] - difference).abs() < 1e-6 * scale,
                    "{} {k}: {} {difference}",
                    part.name,
                    gradient[at]
                );
            }
        }
    }

    /// A block of fewer windows than lanes, after a fuller one, is as good as new.
    #[test]
    fn memory_leaves_no_trace() {
        let shape = Shape { hidden: 16, layers: 2 };
        let network = Network::<f32>::new(shape, &shape.random(5));
        let narrow = |s: &Vec<[f64; INPUTS]>| -> Vec<[f32; INPUTS]> {
            s.iter().map(|v| v.map(|v| v as f32)).collect()
        };
        let data: Vec<_> = samples(3, 9).iter().map(narrow).collect();
        let windows: Vec<Window<'_, f32>> = data.iter().map(|s| Window { samples: s }).collect();
        let run = |tape: &mut Tape<f32>, windows: &[Window<'_, f32>]| {
            let mut gradient = vec![0.0; shape.len()];
            let loss = tape.run(&network, windows, Some(&mut gradient));
            (loss, gradient)
        };
        let fresh = run(&mut Tape::new(&network, 3, 4, 5), &windows[1..2]);
        let mut used = Tape::new(&network, 3, 4, 5);
        run(&mut used, &windows);
        assert_eq!(run(&mut used, &windows[1..2]), fresh);
    }
}
