//! Loss of windows and its exact gradient through all Runge–Kutta steps.

use super::network::{Field, STATES, STRIDE};
use pam_core::simd::Float;

/// Scaled data of one window: states at the ends of steps, forces at ends and middles.
#[derive(Debug, Clone)]
pub struct Window<T> {
    /// `steps + 1` states.
    pub states: Vec<[T; STATES]>,
    /// `2 steps + 1` forces.
    pub forces: Vec<T>,
}

/// Shares of the step at which the stages of RK4 stand behind the stage before, and their weights.
const REACH: [f64; 4] = [0.0, 0.5, 0.5, 1.0];
const WEIGHT: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];
/// Force of a stage, in half steps.
const HALF: [usize; 4] = [0, 1, 1, 2];

/// Memory for loss and gradient of a block of windows.
#[derive(Debug)]
pub struct Tape<T> {
    members: usize,
    steps: usize,
    step_s: f64,
    /// `[4 steps][members][..]`: inputs, hidden layers and the cotangents of the sums.
    inputs: Vec<T>,
    kept: [Vec<T>; 2],
    sums: [Vec<T>; 3],
    /// `[steps + 1][members][4]`.
    states: Vec<[T; STATES]>,
    rates: Vec<T>,
    by_input: Vec<T>,
}

impl<T: Float> Tape<T> {
    /// Memory for up to `members` windows of `steps` steps.
    #[must_use]
    pub fn new(width: usize, members: usize, steps: usize, step_s: f64) -> Self {
        let stages = 4 * steps * members;
        let zeros = |n: usize| vec![T::default(); n];
        Self {
            members,
            steps,
            step_s,
            inputs: zeros(stages * STRIDE),
            kept: [zeros(stages * width), zeros(stages * width)],
            sums: [zeros(stages * width), zeros(stages * width), zeros(stages * STRIDE)],
            states: vec![[T::default(); STATES]; (steps + 1) * members],
            rates: zeros(4 * members * STRIDE),
            by_input: zeros(members * STRIDE),
        }
    }

    /// Sum over windows and steps of the squared scaled errors of all four states; with `gradient` its
    /// exact gradient is added there.
    ///
    /// # Panics
    /// If there are more windows than the batch holds, or a window is too short.
    pub fn run(
        &mut self,
        field: &Field<T>,
        windows: &[&Window<T>],
        gradient: Option<&mut [f64]>,
    ) -> f64 {
        let (n, w) = (windows.len(), field.width);
        assert!(n <= self.members, "more windows than the batch holds");
        let h = T::narrow(self.step_s);
        for (state, window) in self.states.iter_mut().zip(windows) {
            *state = window.states[0];
        }
        let block = n * STRIDE;
        for k in 0..self.steps {
            for s in 0..4 {
                let at = 4 * k + s;
                let inputs = &mut self.inputs[at * block..][..block];
                for (member, column) in inputs.chunks_exact_mut(STRIDE).enumerate() {
                    let state = &self.states[k * n + member];
                    for c in 0..STATES {
                        column[c] = state[c];
                        if s > 0 {
                            let before = self.rates[(s - 1) * block + member * STRIDE + c];
                            column[c] += h * T::narrow(REACH[s]) * before;
                        }
                    }
                    column[STATES] = windows[member].forces[2 * k + HALF[s]];
                }
                let [first, second] = &mut self.kept;
                let keep = [&mut first[at * n * w..], &mut second[at * n * w..]];
                field.eval(n, inputs, keep, &mut self.rates[s * block..]);
            }
            for member in 0..n {
                let mut next = self.states[k * n + member];
                for (s, weight) in WEIGHT.iter().enumerate() {
                    for (c, x) in next.iter_mut().enumerate() {
                        *x += h * T::narrow(*weight) * self.rates[s * block + member * STRIDE + c];
                    }
                }
                self.states[(k + 1) * n + member] = next;
            }
        }
        let mut loss = 0.0;
        for k in 1..=self.steps {
            for (member, window) in windows.iter().enumerate() {
                for c in 0..STATES {
                    let error = (self.states[k * n + member][c] - window.states[k][c]).widen();
                    loss += error * error;
                }
            }
        }
        if let Some(gradient) = gradient {
            self.backward(field, windows);
            let columns = 4 * self.steps * n;
            let kept = [&self.kept[0][..], &self.kept[1][..]];
            let sums = [&self.sums[0][..], &self.sums[1][..], &self.sums[2][..]];
            field.collect(columns, &self.inputs, kept, sums, gradient);
        }
        loss
    }

    fn backward(&mut self, field: &Field<T>, windows: &[&Window<T>]) {
        let (n, w) = (windows.len(), field.width);
        let block = n * STRIDE;
        let h = T::narrow(self.step_s);
        let two = T::narrow(2.0);
        let mut carried = vec![[T::default(); STATES]; n];
        // Cotangents of the rates of the four stages.
        let mut by_rates = vec![T::default(); 4 * block];
        for k in (0..self.steps).rev() {
            for (member, own) in carried.iter_mut().enumerate() {
                for (c, own) in own.iter_mut().enumerate() {
                    let predicted = self.states[(k + 1) * n + member][c];
                    *own += two * (predicted - windows[member].states[k + 1][c]);
                    for (s, weight) in WEIGHT.iter().enumerate() {
                        by_rates[s * block + member * STRIDE + c] = h * T::narrow(*weight) * *own;
                    }
                }
            }
            for s in (0..4).rev() {
                let at = 4 * k + s;
                let outs = &mut self.sums[2][at * block..][..block];
                outs.copy_from_slice(&by_rates[s * block..][..block]);
                let here = at * n * w..(at + 1) * n * w;
                let kept = [&self.kept[0][here.clone()], &self.kept[1][here.clone()]];
                let [first, second, last] = &mut self.sums;
                let hidden = [&mut first[here.clone()], &mut second[here]];
                field.pull_back(n, kept, &mut last[at * block..], hidden, &mut self.by_input);
                for (member, own) in carried.iter_mut().enumerate() {
                    for (c, own) in own.iter_mut().enumerate() {
                        let by = self.by_input[member * STRIDE + c];
                        *own += by;
                        if s > 0 {
                            let before = &mut by_rates[(s - 1) * block + member * STRIDE + c];
                            *before += h * T::narrow(REACH[s]) * by;
                        }
                    }
                }
            }
        }
    }
}
