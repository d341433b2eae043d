//! Loss of windows, with everything kept for its exact gradient through all steps of warm-up and recursion.
//!
//! A block of windows begins at rest, with a warm-up on measured samples, or goes on from where the block
//! before ended: from its hidden states and its last predictions. So a long free run is trained in pieces,
//! each with the exact gradient of its own steps (truncated back-propagation, Williams and Peng 1990).

use super::network::{LayerStep, Network, OUT_STRIDE};
use super::parameters::{INPUTS, OUTPUTS};
use pam_core::simd::{Float, padded};

/// Weights of the squared errors of x, ẋ, P_f and P_e.
pub const LOSS_WEIGHTS: [f64; OUTPUTS] = [100.0, 100.0, 1.0, 1.0];

/// Where a block of windows begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Begin {
    /// At hidden states of zero, with a warm-up on measured samples.
    Rest,
    /// At hidden states and last predictions of the block that ran before.
    Carried,
}

/// Scaled samples of one window: those that are known, then those that are predicted.
#[derive(Debug, Clone, Copy)]
pub struct Window<'a, T> {
    /// State and force of each sample: `warm_up + horizon` of them, or `1 + horizon` where a block goes on;
    /// of the first one only the force is read then.
    pub samples: &'a [[T; INPUTS]],
}

/// Memory for loss and gradient of a block of windows.
#[derive(Debug, Clone)]
pub struct Tape<T> {
    members: usize,
    warm_up: usize,
    pub(super) horizon: usize,
    /// Samples of the present block that are not predicted.
    pub(super) known: usize,
    /// Windows of the block that ran last.
    carried: usize,
    /// `[members]`: its last predictions.
    carried_state: Vec<[T; OUTPUTS]>,
    pub(super) layers: Vec<LayerTape<T>>,
    /// `[horizon][members][hidden]`: hidden states that the head read, and what it made of them.
    pub(super) head_in: Vec<T>,
    pub(super) head_inner: Vec<T>,
    /// `[horizon][members][16]`: outputs, later their cotangents.
    pub(super) out: Vec<T>,
    /// Cotangents of the head.
    pub(super) head_back: Vec<T>,
    /// Cotangents of a layer's input.
    pub(super) input_back: Vec<T>,
    hidden: Vec<T>,
}

/// Values that one layer keeps from all steps, and their cotangents.
#[derive(Debug, Clone)]
pub(super) struct LayerTape<T> {
    /// `[steps + 1][members][inputs + hidden]`.
    pub(super) stack: Vec<T>,
    /// `[steps][members][2 hidden]`.
    pub(super) gates: Vec<T>,
    /// `[steps][members][hidden]`.
    pub(super) new: Vec<T>,
    pub(super) new_hidden: Vec<T>,
    /// `[steps][members][4 hidden]`: cotangents of the sums of reset, update, new, and of `W_hn h + b_hn`.
    pub(super) back: Vec<T>,
    /// `[members][hidden]`: the hidden state at the end of the last block.
    last: Vec<T>,
    /// `[members][hidden]`: cotangent of the hidden state that goes on.
    pub(super) carried: Vec<T>,
    /// `[inputs + hidden][4 hidden]`: the gradient of the weights.
    pub(super) sums: Vec<T>,
}

impl<T: Float> Tape<T> {
    /// Memory for blocks of up to `members` windows.
    #[must_use]
    pub fn new(network: &Network<T>, members: usize, warm_up: usize, horizon: usize) -> Self {
        let h = network.shape.hidden;
        let steps = warm_up + horizon - 1;
        let zeros = |n: usize| vec![T::default(); n];
        let layers = network
            .layers
            .iter()
            .map(|l| LayerTape {
                stack: zeros((steps + 1) * members * (l.inputs + h)),
                gates: zeros(steps * members * 2 * h),
                new: zeros(steps * members * h),
                new_hidden: zeros(steps * members * h),
                back: zeros(steps * members * 4 * h),
                last: zeros(members * h),
                carried: zeros(members * h),
                sums: zeros((l.inputs + h) * 4 * h),
            })
            .collect();
        Self {
            members,
            warm_up,
            horizon,
            known: warm_up,
            carried: 0,
            carried_state: vec![[T::default(); OUTPUTS]; members],
            layers,
            head_in: zeros(horizon * members * h),
            head_inner: zeros(horizon * members * h),
            out: zeros(horizon * members * OUT_STRIDE),
            head_back: zeros(horizon * members * h),
            input_back: zeros(members * h.max(padded(INPUTS))),
            hidden: zeros(members * h),
        }
    }

    /// Sum of squared weighted errors over windows and predicted samples, and with `gradient` its exact
    /// gradient, added there in the order of [`Shape::parts`](super::Shape::parts).
    ///
    /// # Panics
    /// If there are more windows than the batch holds, a window is too short, or a block goes on from one of another
    /// number of windows.
    pub fn run(
        &mut self,
        network: &Network<T>,
        begin: Begin,
        windows: &[Window<'_, T>],
        gradient: Option<&mut [f64]>,
    ) -> f64 {
        let n = windows.len();
        assert!(n <= self.members, "more windows than the batch holds");
        assert!(begin == Begin::Rest || n == self.carried, "a block goes on with the same windows");
        self.known = if begin == Begin::Rest { self.warm_up } else { 1 };
        self.carried = n;
        self.start(network, begin, n);
        let loss = self.forward(network, begin, windows);
        if let Some(gradient) = gradient {
            self.backward(network, n);
            self.collect(network, n, gradient);
        }
        loss
    }

    /// Steps of the present block.
    pub(super) fn steps(&self) -> usize {
        self.known + self.horizon - 1
    }

    /// Sets the hidden states before the first step.
    fn start(&mut self, network: &Network<T>, begin: Begin, n: usize) {
        let h = network.shape.hidden;
        for (tape, layer) in self.layers.iter_mut().zip(&network.layers) {
            let columns = tape.stack[..n * (layer.inputs + h)].chunks_exact_mut(layer.inputs + h);
            for (column, last) in columns.zip(tape.last.chunks_exact(h)) {
                match begin {
                    Begin::Rest => column[layer.inputs..].fill(T::default()),
                    Begin::Carried => column[layer.inputs..].copy_from_slice(last),
                }
            }
        }
    }

    /// Keeps hidden states and predictions after the last step, for a block that goes on.
    fn keep_end(&mut self, network: &Network<T>, n: usize) {
        let (h, steps) = (network.shape.hidden, self.steps());
        for (tape, layer) in self.layers.iter_mut().zip(&network.layers) {
            let stride = layer.inputs + h;
            let columns = tape.stack[steps * n * stride..].chunks_exact(stride);
            for (last, column) in tape.last.chunks_exact_mut(h).zip(columns).take(n) {
                last.copy_from_slice(&column[layer.inputs..]);
            }
        }
        let out = self.out[(self.horizon - 1) * n * OUT_STRIDE..].chunks_exact(OUT_STRIDE);
        for (state, column) in self.carried_state.iter_mut().zip(out).take(n) {
            state.copy_from_slice(&column[..OUTPUTS]);
        }
    }

    /// Predicts and leaves the cotangents of the outputs in `out`.
    fn forward(&mut self, network: &Network<T>, begin: Begin, windows: &[Window<'_, T>]) -> f64 {
        let (n, h) = (windows.len(), network.shape.hidden);
        let count = network.layers.len();
        let mut loss = 0.0;
        for t in 0..self.steps() {
            let block = t * n * (INPUTS + h);
            for (member, window) in windows.iter().enumerate() {
                let to = &mut self.layers[0].stack[block + member * (INPUTS + h)..][..INPUTS];
                to.copy_from_slice(&window.samples[t]);
                if let Some(k) = t.checked_sub(self.known) {
                    let predicted = &self.out[(k * n + member) * OUT_STRIDE..][..OUTPUTS];
                    to[..OUTPUTS].copy_from_slice(predicted);
                } else if begin == Begin::Carried {
                    to[..OUTPUTS].copy_from_slice(&self.carried_state[member]);
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
                for (member, hidden) in self.hidden[..n * h].chunks_exact(h).enumerate() {
                    next[member * stride + stride - h..][..h].copy_from_slice(hidden);
                    if let Some(above) = above.first_mut() {
                        above.stack[(t * n + member) * 2 * h..][..h].copy_from_slice(hidden);
                    }
                }
            }
            let Some(k) = (t + 1).checked_sub(self.known) else { continue };
            let kept = k * n * h..(k + 1) * n * h;
            self.head_in[kept.clone()].copy_from_slice(&self.hidden[..n * h]);
            let out = &mut self.out[k * n * OUT_STRIDE..];
            network.head_forward(n, &self.hidden, &mut self.head_inner[kept], out);
        }
        self.keep_end(network, n);
        // Errors become cotangents only now: predictions were inputs until here.
        for (k, block) in
            self.out[..self.horizon * n * OUT_STRIDE].chunks_exact_mut(n * OUT_STRIDE).enumerate()
        {
            for (column, window) in block.chunks_exact_mut(OUT_STRIDE).zip(windows) {
                let measured = &window.samples[self.known + k];
                for c in 0..OUTPUTS {
                    let error = column[c] - measured[c];
                    loss += LOSS_WEIGHTS[c] * error.widen() * error.widen();
                    column[c] = error * T::narrow(2.0 * LOSS_WEIGHTS[c]);
                }
            }
        }
        loss
    }
}
