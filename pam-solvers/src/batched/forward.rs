//! The lock-step forward solve of one thread's lanes.

use super::{BatchedIntegrator, StoredTrajectory, TrajectoryFailure, TrajectoryProblem};
use crate::controller::StepController;
use crate::error::FailureKind;
use crate::input::{Input, Side};
use crate::step::node;
use crate::stepping;
use pam_autodiff::BatchField;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What one trajectory became.
#[derive(Debug)]
pub(super) struct Slot<K> {
    pub(super) trajectory: StoredTrajectory<K>,
    pub(super) failure: Option<TrajectoryFailure>,
}

impl<K: Default> Default for Slot<K> {
    fn default() -> Self {
        Self { trajectory: StoredTrajectory::default(), failure: None }
    }
}

/// The problems that wait for a lane, and the place of each result.
pub(super) struct Queue<'q, 'p, B: BatchField, I> {
    pub(super) problems: &'q [TrajectoryProblem<'p, B::Condition, I>],
    pub(super) slots: &'q [Mutex<Slot<B::Kept>>],
    pub(super) next: AtomicUsize,
    /// Bytes that each trajectory may keep for its adjoint, if it is to keep any.
    pub(super) keep_bytes: Option<usize>,
}

/// Bookkeeping of one lane.
#[derive(Debug, Clone, Copy, Default)]
struct Member {
    problem: usize,
    t: f64,
    h: f64,
    history: [f64; 2],
    steps: usize,
    /// Cursor into the observation times: those before it are at or before `t`.
    observed: usize,
    /// Whether the first derivative is missing, because the trajectory starts or its input jumped.
    needs_first: bool,
    /// Whether the first derivative was evaluated for this step.
    fresh: bool,
    // The step in progress.
    t_new: f64,
    ends_at_stop: bool,
    jumps: bool,
    interpolates: bool,
}

/// Memory of one thread, for `capacity` lanes.
#[derive(Debug)]
pub(super) struct ForwardMemory<L, K> {
    capacity: usize,
    lanes: Vec<Member>,
    field: L,
    trajectories: Vec<StoredTrajectory<K>>,
    /// `[derivatives][lane][state]`.
    k: Vec<f64>,
    y: Vec<f64>,
    y_new: Vec<f64>,
    scratch: Vec<f64>,
    u: Vec<f64>,
    t: Vec<f64>,
    /// Step of each lane, once for each state.
    h: Vec<f64>,
    /// What the evaluations of the step left, `[derivatives][lane][kept_len]`; empty if nothing is kept.
    kept: Vec<K>,
}

impl<L, K: Copy + Default> ForwardMemory<L, K> {
    pub(super) fn new<B: BatchField<Batch = L, Kept = K>>(
        field: &B,
        derivatives: usize,
        capacity: usize,
    ) -> Self {
        let (n, m) = (field.state_len(), field.input_len());
        let zeros = |len: usize| vec![0.0; len];
        Self {
            capacity,
            lanes: Vec::with_capacity(capacity),
            field: field.batch(capacity),
            trajectories: (0..capacity).map(|_| StoredTrajectory::default()).collect(),
            k: zeros(derivatives * capacity * n),
            y: zeros(capacity * n),
            y_new: zeros(capacity * n),
            scratch: zeros(capacity * n),
            u: zeros(capacity * m),
            t: zeros(capacity),
            h: zeros(capacity * n),
            kept: vec![K::default(); derivatives * capacity * field.kept_len()],
        }
    }

    pub(super) fn capacity(&self) -> usize {
        self.capacity
    }
}

/// One thread at work.
pub(super) struct Forward<'a, 'q, 'p, B: BatchField, I, C> {
    pub(super) settings: &'a BatchedIntegrator<C>,
    pub(super) field: &'a B,
    pub(super) queue: &'a Queue<'q, 'p, B, I>,
    pub(super) memory: &'a mut ForwardMemory<B::Batch, B::Kept>,
}

impl<B, I, C> Forward<'_, '_, '_, B, I, C>
where
    B: BatchField,
    I: Input<f64>,
    C: StepController + Sync,
{
    /// Takes problems from the queue until it is empty and all lanes are done.
    pub(super) fn run(&mut self) {
        self.memory.lanes.clear();
        loop {
            let before = self.memory.lanes.len();
            while self.memory.lanes.len() < self.memory.capacity && self.take_problem() {}
            if self.memory.lanes.is_empty() {
                return;
            }
            self.first_derivatives();
            if self.memory.lanes.len() > before {
                self.first_steps(before);
            }
            self.plan_steps();
            self.stages();
            self.finish_steps();
        }
    }

    /// Puts the next problem of the queue into a new lane.
    fn take_problem(&mut self) -> bool {
        let index = self.queue.next.fetch_add(1, Ordering::Relaxed);
        let Some(problem) = self.queue.problems.get(index) else { return false };
        let (n, m) = (self.field.state_len(), self.field.input_len());
        let mut slot = self.queue.slots[index].lock().expect("no lane panics");
        slot.failure = None;
        let derivatives = self.settings.tableau.derivatives();
        let keeps = self.queue.keep_bytes.is_some() && self.field.kept_len() > 0;
        slot.trajectory.restart(derivatives, problem.t0, &problem.y0, keeps);
        if let Err(why) = self.settings.check(problem, n, m) {
            let kind = FailureKind::Request(why);
            slot.failure = Some(TrajectoryFailure { problem: index, kind, time_s: problem.t0 });
            return true;
        }
        if problem.t0 == problem.t1 {
            return true;
        }
        let lane = self.memory.lanes.len();
        std::mem::swap(&mut slot.trajectory, &mut self.memory.trajectories[lane]);
        self.memory.y[lane * n..(lane + 1) * n].copy_from_slice(&problem.y0);
        self.field.set_condition(lane, &problem.condition, &mut self.memory.field);
        let observed = problem.observe_s.partition_point(|&t| t <= problem.t0);
        self.memory.lanes.push(Member {
            problem: index,
            t: problem.t0,
            history: [1.0, 1.0],
            observed,
            needs_first: true,
            ..Member::default()
        });
        true
    }

    /// Evaluates all lanes at the states in `scratch` and the times in `t`; the inputs are set. The
    /// result goes to derivative `i`.
    fn evaluate(&mut self, i: usize) {
        let (n, m) = (self.field.state_len(), self.field.input_len());
        let memory = &mut *self.memory;
        let (len, stride) = (memory.lanes.len(), memory.capacity * n);
        let dy = &mut memory.k[i * stride..][..len * n];
        let y = &memory.scratch[..len * n];
        let width = if self.queue.keep_bytes.is_some() { self.field.kept_len() } else { 0 };
        let start = i * memory.capacity * width;
        let kept = &mut memory.kept[start..start + len * width];
        let (t, u) = (&memory.t[..len], &memory.u[..len * m]);
        self.field.eval_batch(t, y, u, dy, kept, &mut memory.field);
    }

    /// Sets time and input of a lane.
    fn set_input(&mut self, lane: usize, t: f64, side: Side) {
        let m = self.field.input_len();
        let problem = &self.queue.problems[self.memory.lanes[lane].problem];
        self.memory.t[lane] = t;
        problem.input.value_into(t, side, &mut self.memory.u[lane * m..(lane + 1) * m]);
    }

    /// Evaluates the first derivative of the lanes that lack it.
    fn first_derivatives(&mut self) {
        let n = self.field.state_len();
        let len = self.memory.lanes.len();
        let mut missing = 0;
        for (lane, trajectory) in self.memory.lanes.iter_mut().zip(&mut self.memory.trajectories) {
            // A rejected step keeps its first derivative, and how it came about.
            lane.fresh |= lane.needs_first;
            missing += usize::from(lane.needs_first);
            trajectory.evaluations += usize::from(lane.needs_first);
        }
        if missing == 0 {
            return;
        }
        for lane in 0..len {
            let t = self.memory.lanes[lane].t;
            self.set_input(lane, t, Side::Right);
        }
        self.memory.scratch[..len * n].copy_from_slice(&self.memory.y[..len * n]);
        if missing == len {
            self.evaluate(0);
        } else {
            // Into the last derivative, which nobody needs at the start of a step.
            let last = self.settings.tableau.stages();
            self.evaluate(last);
            let width = self.field.kept_len();
            let memory = &mut *self.memory;
            for lane in (0..len).filter(|&l| memory.lanes[l].needs_first) {
                let from = (last * memory.capacity + lane) * n;
                memory.k.copy_within(from..from + n, lane * n);
                let from = (last * memory.capacity + lane) * width;
                memory.kept.copy_within(from..from + width, lane * width);
            }
        }
        for lane in &mut self.memory.lanes {
            lane.needs_first = false;
        }
    }

    /// The first step of the lanes from `first` on: given, or estimated (see
    /// [`stepping::first_step`]).
    fn first_steps(&mut self, first: usize) {
        let settings = self.settings;
        let n = self.field.state_len();
        let len = self.memory.lanes.len();
        let span = |lane: &Member, problems: &[TrajectoryProblem<'_, B::Condition, I>]| {
            problems[lane.problem].t1 - lane.t
        };
        let Some(tolerances) = settings
            .controller
            .tolerances()
            .filter(|_| settings.controller.initial_step_s().is_none())
        else {
            for lane in &mut self.memory.lanes[first..] {
                let given = settings.controller.initial_step_s();
                lane.h = given.unwrap_or_else(|| span(lane, self.queue.problems));
            }
            return;
        };
        let memory = &mut *self.memory;
        memory.scratch[..len * n].copy_from_slice(&memory.y[..len * n]);
        for lane in first..len {
            let range = lane * n..(lane + 1) * n;
            let (y, k) = (&memory.y[range.clone()], &memory.k[range.clone()]);
            let span = span(&memory.lanes[lane], self.queue.problems);
            let h0 = stepping::probe_step(tolerances, y, k, span);
            memory.lanes[lane].h = h0;
            memory.trajectories[lane].evaluations += 1;
            for (s, &k) in memory.scratch[range.clone()].iter_mut().zip(&memory.k[range]) {
                *s += h0 * k;
            }
        }
        let last = settings.tableau.stages();
        self.evaluate(last);
        let memory = &mut *self.memory;
        let stride = memory.capacity * n;
        for lane in first..len {
            let range = lane * n..(lane + 1) * n;
            for i in range.clone() {
                memory.scratch[i] = memory.k[last * stride + i] - memory.k[i];
            }
            let (y, k) = (&memory.y[range.clone()], &memory.k[range.clone()]);
            let span = span(&memory.lanes[lane], self.queue.problems);
            let (h0, order) = (memory.lanes[lane].h, settings.tableau.order);
            let change = &memory.scratch[range];
            memory.lanes[lane].h =
                stepping::first_step(tolerances, y, k, change, (h0, span), order);
        }
    }

    /// Decides where each lane's step ends.
    fn plan_steps(&mut self) {
        let n = self.field.state_len();
        let memory = &mut *self.memory;
        for (i, lane) in memory.lanes.iter_mut().enumerate() {
            let problem = &self.queue.problems[lane.problem];
            lane.h = lane.h.min(self.settings.controller.largest_step_s());
            let jump = problem.input.next_jump(lane.t).unwrap_or(f64::INFINITY);
            let stop = jump.min(problem.t1);
            lane.ends_at_stop = stepping::reaches(lane.t, lane.h, stop);
            lane.t_new = if lane.ends_at_stop { stop } else { lane.t + lane.h };
            lane.jumps = lane.ends_at_stop && jump == stop;
            lane.interpolates =
                problem.observe_s.get(lane.observed).is_some_and(|&t| t < lane.t_new);
            memory.h[i * n..(i + 1) * n].fill(lane.t_new - lane.t);
        }
    }

    /// Stages two to `s`, the new states, and the closing derivative if any lane needs it.
    fn stages(&mut self) {
        let settings = self.settings;
        let tableau = &settings.tableau;
        let n = self.field.state_len();
        let len = self.memory.lanes.len();
        for i in 1..tableau.stages() {
            self.combine(&tableau.a[i], false);
            let c = tableau.c[i];
            for lane in 0..len {
                let Member { t, t_new, .. } = self.memory.lanes[lane];
                let (t, side) = node(c, t, t_new);
                self.set_input(lane, t, side);
            }
            self.evaluate(i);
        }
        self.combine(&tableau.b, true);
        let adaptive = settings.controller.tolerances().is_some();
        let problems = self.queue.problems;
        let closes = |lane: &Member| {
            let at_end = lane.t_new == problems[lane.problem].t1;
            adaptive || lane.interpolates || !(lane.jumps || at_end)
        };
        if self.memory.lanes.iter().any(closes) {
            for lane in 0..len {
                let t_new = self.memory.lanes[lane].t_new;
                self.set_input(lane, t_new, Side::Left);
            }
            self.memory.scratch[..len * n].copy_from_slice(&self.memory.y_new[..len * n]);
            self.evaluate(tableau.stages());
        }
    }

    /// `y + h Σ_j weights_j k_j`, into the new states or into `scratch`.
    fn combine(&mut self, weights: &[f64], to_new: bool) {
        let n = self.field.state_len();
        let memory = &mut *self.memory;
        let (len, stride) = (memory.lanes.len() * n, memory.capacity * n);
        let target = if to_new { &mut memory.y_new } else { &mut memory.scratch };
        target[..len].copy_from_slice(&memory.y[..len]);
        for (k, &w) in memory.k.chunks_exact(stride).zip(weights) {
            if w != 0.0 {
                for ((o, &k), &h) in target[..len].iter_mut().zip(k).zip(&memory.h) {
                    *o += k * (h * w);
                }
            }
        }
    }

    /// Accepts or rejects each lane's step, records it, and frees the lanes that are done.
    fn finish_steps(&mut self) {
        let mut lane = 0;
        while lane < self.memory.lanes.len() {
            match self.finish_step(lane) {
                None => lane += 1,
                Some(failure) => self.free(lane, failure),
            }
        }
    }

    /// Ends the step of one lane. `Some` if the lane is done: with a failure, or without.
    fn finish_step(&mut self, index: usize) -> Option<Option<TrajectoryFailure>> {
        let settings = self.settings;
        let tableau = &settings.tableau;
        let n = self.field.state_len();
        let memory = &mut *self.memory;
        let stride = memory.capacity * n;
        let range = index * n..(index + 1) * n;
        let lane = &mut memory.lanes[index];
        let problem = &self.queue.problems[lane.problem];
        let fail = |lane: &Member, kind| {
            Some(Some(TrajectoryFailure { problem: lane.problem, kind, time_s: lane.t }))
        };
        if lane.steps == settings.max_steps {
            return fail(lane, FailureKind::TooManySteps { limit: settings.max_steps });
        }
        lane.steps += 1;
        let adaptive = settings.controller.tolerances();
        let at_end = lane.t_new == problem.t1;
        let closed = adaptive.is_some() || lane.interpolates || !(lane.jumps || at_end);
        memory.trajectories[index].evaluations += tableau.stages() - 1 + usize::from(closed);
        let taken = lane.t_new - lane.t;
        let smallest = 4.0 * f64::EPSILON * lane.t.abs();
        if !lane.ends_at_stop && taken <= smallest {
            return fail(lane, FailureKind::StepTooSmall { step_s: lane.h });
        }
        let (y, y_new) = (&memory.y[range.clone()], &memory.y_new[range.clone()]);
        let mut factor = 1.0;
        if let (Some(tolerances), Some(weights)) = (adaptive, &tableau.error) {
            let error = &mut memory.scratch[range.clone()];
            error.fill(0.0);
            for (k, &w) in memory.k.chunks_exact(stride).zip(weights) {
                for (e, &k) in error.iter_mut().zip(&k[range.clone()]) {
                    *e += k * (taken * w);
                }
            }
            let error = tolerances.norm(error, y, y_new);
            let order = tableau.embedded_order.unwrap_or(tableau.order - 1) + 1;
            let decision = settings.controller.decide(error, lane.history, order);
            if !decision.accept {
                memory.trajectories[index].rejected += 1;
                lane.h = taken * decision.factor;
                if lane.h <= smallest || lane.h < f64::MIN_POSITIVE {
                    let kind = if error.is_finite() {
                        FailureKind::StepTooSmall { step_s: lane.h }
                    } else {
                        FailureKind::NonFinite { step_s: taken }
                    };
                    return fail(lane, kind);
                }
                return None;
            }
            factor = decision.factor;
            lane.history = [error, lane.history[0]];
        }
        if y_new.iter().any(|v| !v.is_finite()) {
            return fail(lane, FailureKind::NonFinite { step_s: taken });
        }
        let derivatives = memory.k.chunks_exact(stride).map(|k| &k[range.clone()]);
        let trajectory = &mut memory.trajectories[index];
        trajectory.push(lane.t_new, y_new, derivatives, lane.fresh, closed);
        if let Some(limit) = self.queue.keep_bytes {
            let width = self.field.kept_len();
            let first = if lane.fresh { 0 } else { 1 };
            for i in first..tableau.stages() + usize::from(closed) {
                let start = (i * memory.capacity + index) * width;
                trajectory.keep(&memory.kept[start..start + width], limit);
            }
        }
        if at_end {
            return Some(None);
        }
        lane.h = if lane.ends_at_stop { lane.h.max(taken * factor) } else { lane.h * factor };
        lane.t = lane.t_new;
        while problem.observe_s.get(lane.observed).is_some_and(|&t| t <= lane.t) {
            lane.observed += 1;
        }
        memory.y[range.clone()].copy_from_slice(&memory.y_new[range]);
        lane.fresh = false;
        if lane.jumps {
            lane.needs_first = true;
        } else {
            let closing = tableau.stages() * stride + index * n;
            memory.k.copy_within(closing..closing + n, index * n);
        }
        None
    }

    /// Hands the trajectory of a lane to its slot and moves the last lane into its place.
    fn free(&mut self, index: usize, failure: Option<TrajectoryFailure>) {
        let n = self.field.state_len();
        let memory = &mut *self.memory;
        {
            let mut slot =
                self.queue.slots[memory.lanes[index].problem].lock().expect("no lane panics");
            std::mem::swap(&mut slot.trajectory, &mut memory.trajectories[index]);
            slot.failure = failure;
        }
        let last = memory.lanes.len() - 1;
        memory.lanes.swap_remove(index);
        if index == last {
            return;
        }
        memory.trajectories.swap(index, last);
        self.field.move_condition(last, index, &mut memory.field);
        let (from, to) = (last * n..(last + 1) * n, index * n);
        for buffer in [&mut memory.y, &mut memory.y_new, &mut memory.h] {
            buffer.copy_within(from.clone(), to);
        }
        let stride = memory.capacity * n;
        for k in memory.k.chunks_exact_mut(stride) {
            k.copy_within(from.clone(), to);
        }
        let width = self.field.kept_len();
        for kept in memory.kept.chunks_exact_mut((memory.capacity * width).max(1)) {
            kept.copy_within(last * width..(last + 1) * width, index * width);
        }
    }
}
