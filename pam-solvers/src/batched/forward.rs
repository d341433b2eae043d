//! The forward solve of one thread's batch in lock-step.

use super::members::{Member, Members};
use super::{BatchedIntegrator, StoredTrajectory, TrajectoryFailure, TrajectoryProblem};
use crate::controller::StepController;
use crate::error::FailureKind;
use crate::input::{Input, Side};
use crate::step::error_into;
use crate::step_control::{FirstStep, StepControl, Stops};
use pam_autodiff::BatchField;
use pam_autodiff::batch::Points;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The result of one problem.
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

/// The problems that wait for a place in a batch, and the place of each result.
pub(super) struct Queue<'q, 'p, B: BatchField, I> {
    pub(super) problems: &'q [TrajectoryProblem<'p, B::Condition, I>],
    pub(super) slots: &'q [Mutex<Slot<B::Kept>>],
    pub(super) next: AtomicUsize,
    /// Bytes that each trajectory may keep for its adjoint, if it is to keep any.
    pub(super) keep_bytes: Option<usize>,
}

/// One thread at work.
pub(super) struct Forward<'a, 'q, 'p, B: BatchField, I, C> {
    pub(super) settings: &'a BatchedIntegrator<C>,
    pub(super) field: &'a B,
    pub(super) queue: &'a Queue<'q, 'p, B, I>,
    pub(super) members: &'a mut Members<B::Batch, B::Kept>,
}

/// How a trajectory left the batch: at its end, or for a reason.
type Left = Option<FailureKind>;

impl<B, I, C> Forward<'_, '_, '_, B, I, C>
where
    B: BatchField,
    I: Input<f64>,
    C: StepController + Sync,
{
    /// Takes problems from the queue until it is empty and the last trajectory has ended.
    pub(super) fn run(&mut self) {
        self.members.list.clear();
        loop {
            let before = self.members.list.len();
            while self.members.list.len() < self.members.capacity && self.take_problem() {}
            if self.members.list.is_empty() {
                return;
            }
            self.first_stages();
            if self.members.list.len() > before {
                self.first_steps(before);
            }
            self.for_each_member(Self::propose);
            self.stages();
            self.for_each_member(Self::finish);
        }
    }

    /// Calls `advance` for every member; those that it breaks off leave the batch.
    fn for_each_member(&mut self, advance: impl Fn(&mut Self, usize) -> ControlFlow<Left>) {
        let mut index = 0;
        while index < self.members.list.len() {
            match advance(self, index) {
                ControlFlow::Continue(()) => index += 1,
                ControlFlow::Break(left) => self.remove(index, left),
            }
        }
    }

    /// Adds the next problem of the queue to the batch; `false` if there is none.
    fn take_problem(&mut self) -> bool {
        let index = self.queue.next.fetch_add(1, Ordering::Relaxed);
        let Some(problem) = self.queue.problems.get(index) else { return false };
        let (n, m) = (self.field.state_len(), self.field.input_len());
        let mut slot = self.queue.slots[index].lock().expect("no thread panics");
        slot.failure = None;
        let stages = self.settings.tableau.stages_with_fsal();
        let keeps = self.queue.keep_bytes.is_some() && self.field.kept_len() > 0;
        slot.trajectory.restart(stages, problem.t0, &problem.y0, keeps);
        if let Err(why) = self.settings.check(problem, n, m) {
            let kind = FailureKind::Request(why);
            slot.failure = Some(TrajectoryFailure { problem: index, kind, time_s: problem.t0 });
            return true;
        }
        if problem.t0 == problem.t1 {
            return true;
        }
        let members = &mut *self.members;
        let place = members.list.len();
        std::mem::swap(&mut slot.trajectory, &mut members.trajectories[place]);
        members.y[place * n..(place + 1) * n].copy_from_slice(&problem.y0);
        self.field.set_condition(place, &problem.condition, &mut members.field);
        members.list.push(Member {
            problem: index,
            control: StepControl::new(problem.t0),
            observed: problem.observe_s.partition_point(|&t| t <= problem.t0),
            needs_first: true,
            ..Member::default()
        });
        true
    }

    /// Evaluates stage `i` of all members at the states in `scratch` and the times in `t`; the inputs
    /// are set.
    fn evaluate(&mut self, i: usize) {
        let (n, m) = (self.field.state_len(), self.field.input_len());
        let members = &mut *self.members;
        let (len, stride) = (members.list.len(), members.capacity * n);
        let dy = &mut members.k[i * stride..][..len * n];
        let y = &members.scratch[..len * n];
        let width = if self.queue.keep_bytes.is_some() { self.field.kept_len() } else { 0 };
        let start = i * members.capacity * width;
        let kept = &mut members.kept[start..start + len * width];
        let points = Points { t: &members.t[..len], y, u: &members.u[..len * m] };
        self.field.eval_batch(points, dy, kept, &mut members.field);
    }

    /// Sets time and input of every member.
    fn set_inputs(&mut self, at: impl Fn(&Member) -> (f64, Side)) {
        let m = self.field.input_len();
        for (i, member) in self.members.list.iter().enumerate() {
            let (t, side) = at(member);
            self.members.t[i] = t;
            let u = &mut self.members.u[i * m..(i + 1) * m];
            self.queue.problems[member.problem].input.value_into(t, side, u);
        }
    }

    /// Evaluates the first stage of the members that lack it.
    fn first_stages(&mut self) {
        let n = self.field.state_len();
        let len = self.members.list.len();
        let mut missing = 0;
        for (member, trajectory) in self.members.list.iter_mut().zip(&mut self.members.trajectories)
        {
            // A step that is tried again keeps its first stage, and where that came from.
            member.restarts |= member.needs_first;
            missing += usize::from(member.needs_first);
            trajectory.evaluations += usize::from(member.needs_first);
        }
        if missing == 0 {
            return;
        }
        self.set_inputs(|member| (member.control.t, Side::Right));
        self.members.scratch[..len * n].copy_from_slice(&self.members.y[..len * n]);
        if missing == len {
            self.evaluate(0);
        } else {
            // Into the FSAL stage, which nobody needs at the start of a step.
            let fsal = self.settings.tableau.stages();
            self.evaluate(fsal);
            let width = self.field.kept_len();
            let members = &mut *self.members;
            for i in (0..len).filter(|&i| members.list[i].needs_first) {
                let from = (fsal * members.capacity + i) * n;
                members.k.copy_within(from..from + n, i * n);
                let from = (fsal * members.capacity + i) * width;
                members.kept.copy_within(from..from + width, i * width);
            }
        }
        for member in &mut self.members.list {
            member.needs_first = false;
        }
    }

    /// The first step of the members from `first` on: given, or estimated (see [`FirstStep`]).
    fn first_steps(&mut self, first: usize) {
        let BatchedIntegrator { tableau, controller, .. } = self.settings;
        let problems = self.queue.problems;
        let span_s = |member: &Member| problems[member.problem].t1 - member.control.t;
        let given = controller.initial_step_s();
        let Some(tolerances) = controller.tolerances().filter(|_| given.is_none()) else {
            for member in &mut self.members.list[first..] {
                member.control.h = given.unwrap_or_else(|| span_s(member));
            }
            return;
        };
        let estimate = |member: &Member| FirstStep {
            tolerances,
            order: tableau.order,
            span_s: span_s(member),
        };
        let n = self.field.state_len();
        let members = &mut *self.members;
        let len = members.list.len();
        members.scratch[..len * n].copy_from_slice(&members.y[..len * n]);
        for (i, member) in members.list.iter_mut().enumerate().skip(first) {
            let range = i * n..(i + 1) * n;
            let (y, k) = (&members.y[range.clone()], &members.k[range.clone()]);
            let h0 = estimate(member).probe_s(y, k);
            member.control.h = h0;
            members.trajectories[i].evaluations += 1;
            for (s, &k) in members.scratch[range].iter_mut().zip(k) {
                *s += h0 * k;
            }
        }
        let fsal = tableau.stages();
        self.evaluate(fsal);
        let members = &mut *self.members;
        let (k, probed) = members.k.split_at(fsal * members.capacity * n);
        for (i, member) in members.list.iter_mut().enumerate().skip(first) {
            let range = i * n..(i + 1) * n;
            let (y, k) = (&members.y[range.clone()], &k[range.clone()]);
            let change = &mut members.scratch[range.clone()];
            for ((c, &after), &before) in change.iter_mut().zip(&probed[range]).zip(k) {
                *c = after - before;
            }
            member.control.h = estimate(member).estimate_s(y, k, change, member.control.h);
        }
    }

    /// Proposes the next step of one member.
    fn propose(&mut self, index: usize) -> ControlFlow<Left> {
        let n = self.field.state_len();
        let BatchedIntegrator { controller, limit, .. } = self.settings;
        let member = &mut self.members.list[index];
        let problem = &self.queue.problems[member.problem];
        let jump = problem.input.next_jump(member.control.t);
        let stops = Stops { jump, user: None, end: problem.t1 };
        match member.control.propose(controller, stops, limit) {
            Ok(step) => member.step = step,
            Err(kind) => return ControlFlow::Break(Some(kind)),
        }
        let t_new = member.step.t_new;
        member.interpolates = problem.observe_s.get(member.observed).is_some_and(|&t| t < t_new);
        self.members.h[index * n..(index + 1) * n].fill(member.step.size_s());
        ControlFlow::Continue(())
    }

    /// Stages two to `s`, the new states, and the FSAL stage if any member needs it.
    fn stages(&mut self) {
        let tableau = &self.settings.tableau;
        let len = self.members.list.len() * self.field.state_len();
        if len == 0 {
            return;
        }
        for i in 1..tableau.stages() {
            self.members.combine(&tableau.a[i], false);
            self.set_inputs(|member| tableau.stage_time(i, member.step.t, member.step.t_new));
            self.evaluate(i);
        }
        self.members.combine(&tableau.b, true);
        let adaptive = self.settings.controller.tolerances().is_some();
        if self.members.list.iter().any(|m| m.step.needs_fsal(adaptive, m.interpolates)) {
            self.set_inputs(|member| (member.step.t_new, Side::Left));
            self.members.scratch[..len].copy_from_slice(&self.members.y_new[..len]);
            self.evaluate(tableau.stages());
        }
    }

    /// Accepts or rejects the step of one member, and records it.
    fn finish(&mut self, index: usize) -> ControlFlow<Left> {
        let BatchedIntegrator { tableau, controller, .. } = self.settings;
        let n = self.field.state_len();
        let members = &mut *self.members;
        let stride = members.capacity * n;
        let range = index * n..(index + 1) * n;
        let (member, trajectory) = (&mut members.list[index], &mut members.trajectories[index]);
        let step = member.step;
        let has_fsal = step.needs_fsal(controller.tolerances().is_some(), member.interpolates);
        trajectory.evaluations += tableau.stages() - 1 + usize::from(has_fsal);
        let k = || members.k.chunks_exact(stride).map(|k| &k[range.clone()]);
        let y_new = &members.y_new[range.clone()];
        let error = match (controller.tolerances(), &tableau.error) {
            (Some(tolerances), Some(weights)) => {
                let error = &mut members.scratch[range.clone()];
                error_into(weights, step.size_s(), k(), error);
                Some(tolerances.norm(error, &members.y[range.clone()], y_new))
            }
            _ => None,
        };
        let judged = member.control.judge(controller, tableau, &step, error, y_new);
        trajectory.rejected = member.control.rejected;
        match judged {
            Ok(true) => {}
            Ok(false) => return ControlFlow::Continue(()),
            Err(kind) => return ControlFlow::Break(Some(kind)),
        }
        trajectory.push(step.t_new, y_new, k(), member.restarts, has_fsal);
        if let Some(limit) = self.queue.keep_bytes {
            let width = self.field.kept_len();
            for i in usize::from(!member.restarts)..tableau.stages() + usize::from(has_fsal) {
                let start = (i * members.capacity + index) * width;
                trajectory.keep(&members.kept[start..start + width], limit);
            }
        }
        if step.at_end {
            return ControlFlow::Break(None);
        }
        let observe_s = self.queue.problems[member.problem].observe_s;
        while observe_s.get(member.observed).is_some_and(|&t| t <= step.t_new) {
            member.observed += 1;
        }
        members.y[range.clone()].copy_from_slice(y_new);
        member.restarts = false;
        member.needs_first = step.jumps;
        if !step.jumps {
            let fsal = tableau.stages() * stride + range.start;
            members.k.copy_within(fsal..fsal + n, range.start);
        }
        ControlFlow::Continue(())
    }

    /// Hands the trajectory of a member to its slot; the last member takes its place.
    fn remove(&mut self, index: usize, left: Left) {
        let members = &mut *self.members;
        let Member { problem, control, .. } = members.list[index];
        let mut slot = self.queue.slots[problem].lock().expect("no thread panics");
        std::mem::swap(&mut slot.trajectory, &mut members.trajectories[index]);
        slot.failure = left.map(|kind| TrajectoryFailure { problem, kind, time_s: control.t });
        let last = members.list.len() - 1;
        members.swap_remove(index);
        if index < last {
            self.field.move_condition(last, index, &mut members.field);
        }
    }
}
