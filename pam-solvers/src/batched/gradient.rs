//! Solves and gradients of a set of trajectories on all threads.

use super::adjoint::{Adjoint, AdjointMemory, AdjointSums};
use super::forward::{Forward, Queue, Slot};
use super::members::Members;
use super::{BatchedIntegrator, StoredTrajectory, TrajectoryFailure, TrajectoryProblem};
use crate::controller::StepController;
use crate::input::Input;
use pam_autodiff::BatchField;
use pam_autodiff::batch::ParameterSums;
use pam_core::parallel;
use rayon::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::AtomicUsize;

/// Memory for what the evaluations of all trajectories leave for the adjoint. A trajectory that needs more
/// than its share is evaluated again on the way back, with the same result.
const KEEP_BYTES: usize = 2 << 30;

/// Memory that is kept between calls, so that a repeated solve or gradient allocates next to nothing.
#[derive(Debug)]
pub struct BatchWorkspace<B: BatchField> {
    slots: Vec<Mutex<Slot<B::Kept>>>,
    forward: Mutex<Vec<Members<B::Batch, B::Kept>>>,
    adjoint: Mutex<Vec<AdjointMemory<B::Block>>>,
    results: Vec<Mutex<OneResult>>,
}

impl<B: BatchField> Default for BatchWorkspace<B> {
    fn default() -> Self {
        Self {
            slots: Vec::new(),
            forward: Mutex::new(Vec::new()),
            adjoint: Mutex::new(Vec::new()),
            results: Vec::new(),
        }
    }
}

/// Value and gradient of one trajectory.
#[derive(Debug, Default)]
struct OneResult {
    value: f64,
    states: Vec<f64>,
    cotangents: Vec<f64>,
    shared: Vec<f64>,
    own: Vec<f64>,
    initial_state: Vec<f64>,
    linearised: usize,
}

/// Value and gradient of a sum over trajectories.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BatchGradient {
    /// The sum of the losses.
    pub value: f64,
    /// The loss of each trajectory; NaN where it stopped early.
    pub values: Vec<f64>,
    /// With respect to the parameters that all share.
    pub shared: Vec<f64>,
    /// With respect to each condition's own parameters.
    pub own: Vec<Vec<f64>>,
    /// With respect to each initial state.
    pub initial_state: Vec<Vec<f64>>,
    /// Trajectories that stopped early; they add nothing to value and gradient.
    pub failures: Vec<TrajectoryFailure>,
    /// Accepted steps of all trajectories.
    pub accepted: usize,
    /// Rejected steps of all trajectories.
    pub rejected: usize,
    /// Evaluations of the field, point by point.
    pub evaluations: usize,
    /// Points that the adjoint linearised.
    pub linearised: usize,
    /// Bytes of the stored trajectories.
    pub stored_bytes: usize,
}

impl<C: StepController + Sync> BatchedIntegrator<C> {
    /// Solves all problems. The trajectories stay in `memory`, to be read with
    /// [`BatchWorkspace::trajectory`].
    pub fn solve<B, I>(
        &self,
        field: &B,
        problems: &[TrajectoryProblem<'_, B::Condition, I>],
        memory: &mut BatchWorkspace<B>,
    ) -> Vec<TrajectoryFailure>
    where
        B: BatchField,
        I: Input<f64> + Sync,
    {
        self.forward(field, problems, memory, false);
        memory.slots[..problems.len()]
            .iter_mut()
            .filter_map(|slot| slot.get_mut().expect("no thread panics").failure.clone())
            .collect()
    }

    /// Runs the forward solve on all threads.
    fn forward<B, I>(
        &self,
        field: &B,
        problems: &[TrajectoryProblem<'_, B::Condition, I>],
        memory: &mut BatchWorkspace<B>,
        keep: bool,
    ) where
        B: BatchField,
        I: Input<f64> + Sync,
    {
        let threads = rayon::current_num_threads().clamp(1, problems.len().max(1));
        let capacity = self.width.min(problems.len().div_ceil(threads)).max(1);
        if memory.slots.len() < problems.len() {
            memory.slots.resize_with(problems.len(), Mutex::default);
        }
        let pool = memory.forward.get_mut().expect("no thread panics");
        pool.retain(|members| members.capacity == capacity);
        let stages = self.tableau.stages_with_fsal();
        while pool.len() < threads {
            pool.push(Members::new(field, stages, capacity));
        }
        let queue = Queue {
            problems,
            slots: &memory.slots,
            next: AtomicUsize::new(0),
            keep_bytes: keep.then(|| KEEP_BYTES / problems.len().max(1)),
        };
        pool[..threads]
            .par_iter_mut()
            .for_each(|members| Forward { settings: self, field, queue: &queue, members }.run());
    }

    /// The sum of the losses of all problems with its gradient.
    ///
    /// `loss(index, states, cotangents)` gets the observed states `[times, states]` of problem `index`,
    /// writes the loss's derivative with respect to them to `cotangents` (zeros on entry) and returns
    /// the loss. It is called from several threads.
    pub fn value_and_gradient<B, I>(
        &self,
        field: &B,
        problems: &[TrajectoryProblem<'_, B::Condition, I>],
        loss: &(impl Fn(usize, &[f64], &mut [f64]) -> f64 + Sync),
        memory: &mut BatchWorkspace<B>,
    ) -> BatchGradient
    where
        B: BatchField,
        I: Input<f64> + Sync,
    {
        self.evaluate(field, problems, loss, memory, true)
    }

    /// As [`value_and_gradient`](Self::value_and_gradient), without `backward` the losses alone: the gradients of
    /// the result are then zero.
    pub fn evaluate<B, I>(
        &self,
        field: &B,
        problems: &[TrajectoryProblem<'_, B::Condition, I>],
        loss: &(impl Fn(usize, &[f64], &mut [f64]) -> f64 + Sync),
        memory: &mut BatchWorkspace<B>,
        backward: bool,
    ) -> BatchGradient
    where
        B: BatchField,
        I: Input<f64> + Sync,
    {
        self.forward(field, problems, memory, backward);
        if memory.results.len() < problems.len() {
            memory.results.resize_with(problems.len(), Mutex::default);
        }
        let BatchWorkspace { slots, adjoint, results, .. } = &*memory;
        // One task each, and the longest work is not left for the end.
        parallel::for_each(problems.len(), &|index| {
            let slot = slots[index].lock().expect("no thread panics");
            let mut result = results[index].lock().expect("no thread panics");
            if slot.failure.is_some() {
                result.clear(field, 0);
                return;
            }
            let (problem, trajectory) = (&problems[index], &slot.trajectory);
            let result = &mut *result;
            result.clear(field, problem.observe_s.len());
            trajectory.observe(&self.tableau, problem.observe_s, &mut result.states);
            result.value = loss(index, &result.states, &mut result.cotangents);
            if !backward {
                return;
            }
            let mut own = adjoint
                .lock()
                .expect("no thread panics")
                .pop()
                .unwrap_or_else(|| AdjointMemory::new(field, self.block_points));
            let mut sums = AdjointSums {
                parameters: ParameterSums { shared: &mut result.shared, own: &mut result.own },
                initial_state: &mut result.initial_state,
            };
            let cotangents = &result.cotangents;
            result.linearised = Adjoint { settings: self, field, problem, trajectory, cotangents }
                .run(&mut sums, &mut own);
            adjoint.lock().expect("no thread panics").push(own);
        });
        let mut sum =
            BatchGradient { shared: vec![0.0; field.parameter_len()], ..BatchGradient::default() };
        for (slot, result) in memory.slots.iter_mut().zip(&mut memory.results).take(problems.len())
        {
            let slot = slot.get_mut().expect("no thread panics");
            sum.add(slot, result.get_mut().expect("no thread panics"));
        }
        sum
    }
}

impl OneResult {
    /// Zeros everything for `observations` observations; keeps the memory.
    fn clear<B: BatchField>(&mut self, field: &B, observations: usize) {
        let n = field.state_len();
        let zero = |buffer: &mut Vec<f64>, len: usize| {
            buffer.clear();
            buffer.resize(len, 0.0);
        };
        self.value = f64::NAN;
        zero(&mut self.states, observations * n);
        zero(&mut self.cotangents, observations * n);
        zero(&mut self.shared, field.parameter_len());
        zero(&mut self.own, field.condition_len());
        zero(&mut self.initial_state, n);
        self.linearised = 0;
    }
}

impl BatchGradient {
    fn add<K: Copy>(&mut self, slot: &Slot<K>, result: &OneResult) {
        self.values.push(result.value);
        self.own.push(result.own.clone());
        self.initial_state.push(result.initial_state.clone());
        self.accepted += slot.trajectory.steps();
        self.rejected += slot.trajectory.rejected;
        self.evaluations += slot.trajectory.evaluations;
        self.stored_bytes += slot.trajectory.bytes();
        if let Some(failure) = &slot.failure {
            self.failures.push(failure.clone());
            return;
        }
        self.value += result.value;
        self.linearised += result.linearised;
        for (sum, &g) in self.shared.iter_mut().zip(&result.shared) {
            *sum += g;
        }
    }
}

impl<B: BatchField> BatchWorkspace<B> {
    /// The trajectory of a problem of the last solve.
    ///
    /// # Panics
    /// If there was no such problem.
    pub fn trajectory(&mut self, problem: usize) -> &StoredTrajectory<B::Kept> {
        &self.slots[problem].get_mut().expect("no thread panics").trajectory
    }

    /// The observed states `[times, states]` of a problem of the last gradient; empty if it stopped
    /// early.
    ///
    /// # Panics
    /// If there was no such problem.
    pub fn observed(&mut self, problem: usize) -> &[f64] {
        &self.results[problem].get_mut().expect("no thread panics").states
    }
}
