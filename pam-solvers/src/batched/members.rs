//! The batch of one thread: its trajectories and their memory.

use super::StoredTrajectory;
use crate::step_control::{ProposedStep, StepControl};
use pam_autodiff::BatchField;

/// One trajectory of the batch.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Member {
    pub(super) problem: usize,
    pub(super) control: StepControl,
    /// The step in progress.
    pub(super) step: ProposedStep,
    /// Cursor into the observation times: those before it are at or before the time reached.
    pub(super) observed: usize,
    /// The first stage is missing, because the trajectory starts or its input jumped.
    pub(super) needs_first: bool,
    /// The step in progress restarts: its first stage is not the FSAL stage of its predecessor.
    pub(super) restarts: bool,
    /// An observation lies inside the step in progress.
    pub(super) interpolates: bool,
}

/// Memory of one thread for up to `capacity` trajectories.
#[derive(Debug)]
pub(super) struct Members<F, K> {
    pub(super) capacity: usize,
    pub(super) list: Vec<Member>,
    /// The field's own memory.
    pub(super) field: F,
    pub(super) trajectories: Vec<StoredTrajectory<K>>,
    /// Stage derivatives `[stages][member][state]`, the FSAL stage last.
    pub(super) k: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) y_new: Vec<f64>,
    pub(super) scratch: Vec<f64>,
    pub(super) u: Vec<f64>,
    pub(super) t: Vec<f64>,
    /// Step of each member, once for each state.
    pub(super) h: Vec<f64>,
    /// Numbers that the evaluations of the step left for their linearisation, `[stages][member][kept_len]`; empty if nothing is kept.
    pub(super) kept: Vec<K>,
    state_len: usize,
    kept_len: usize,
}

impl<F, K: Copy + Default> Members<F, K> {
    pub(super) fn new<B: BatchField<Batch = F, Kept = K>>(
        field: &B,
        stages: usize,
        capacity: usize,
    ) -> Self {
        let (n, m) = (field.state_len(), field.input_len());
        let zeros = |len: usize| vec![0.0; len];
        Self {
            capacity,
            list: Vec::with_capacity(capacity),
            field: field.batch(capacity),
            trajectories: (0..capacity).map(|_| StoredTrajectory::default()).collect(),
            k: zeros(stages * capacity * n),
            y: zeros(capacity * n),
            y_new: zeros(capacity * n),
            scratch: zeros(capacity * n),
            u: zeros(capacity * m),
            t: zeros(capacity),
            h: zeros(capacity * n),
            kept: vec![K::default(); stages * capacity * field.kept_len()],
            state_len: n,
            kept_len: field.kept_len(),
        }
    }

    /// `y + h Σ_j weights_j k_j` of every member, into the new states or into `scratch`.
    pub(super) fn combine(&mut self, weights: &[f64], to_new: bool) {
        let (len, stride) = (self.list.len() * self.state_len, self.capacity * self.state_len);
        let target = if to_new { &mut self.y_new } else { &mut self.scratch };
        target[..len].copy_from_slice(&self.y[..len]);
        for (k, &w) in self.k.chunks_exact(stride).zip(weights) {
            if w != 0.0 {
                for ((o, &k), &h) in target[..len].iter_mut().zip(k).zip(&self.h) {
                    *o += k * (h * w);
                }
            }
        }
    }

    /// Removes a member; the last one takes its place.
    pub(super) fn swap_remove(&mut self, index: usize) {
        let last = self.list.len() - 1;
        self.list.swap_remove(index);
        if index == last {
            return;
        }
        self.trajectories.swap(index, last);
        let n = self.state_len;
        let (from, to) = (last * n..(last + 1) * n, index * n);
        for buffer in [&mut self.y, &mut self.y_new, &mut self.h] {
            buffer.copy_within(from.clone(), to);
        }
        for k in self.k.chunks_exact_mut(self.capacity * n) {
            k.copy_within(from.clone(), to);
        }
        let width = self.kept_len;
        for kept in self.kept.chunks_exact_mut((self.capacity * width).max(1)) {
            kept.copy_within(last * width..(last + 1) * width, index * width);
        }
    }
}
