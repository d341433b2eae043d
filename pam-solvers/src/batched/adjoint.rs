//! The exact discrete adjoint of one trajectory, block by block from its end.

use super::{BatchedIntegrator, StoredTrajectory, TrajectoryProblem};
use crate::controller::StepController;
use crate::input::Input;
use crate::observations::Observations;
use crate::step::combine_into;
use crate::tableau::Transpose;
use pam_autodiff::BatchField;
use pam_autodiff::batch::{ParameterSums, Points};
use std::ops::Range;

/// Memory of one adjoint.
#[derive(Debug)]
pub(super) struct AdjointMemory<M> {
    block: M,
    points: usize,
    t: Vec<f64>,
    y: Vec<f64>,
    u: Vec<f64>,
    jacobians: Vec<f64>,
    /// Cotangents of the derivatives at the points.
    w: Vec<f64>,
    transpose: Transpose,
}

impl<M> AdjointMemory<M> {
    pub(super) fn new<B: BatchField<Block = M>>(field: &B, points: usize) -> Self {
        let (n, m) = (field.state_len(), field.input_len());
        Self {
            transpose: Transpose::default(),
            block: field.block(points),
            points,
            t: vec![0.0; points],
            y: vec![0.0; points * n],
            u: vec![0.0; points * m],
            jacobians: vec![0.0; points * n * n],
            w: vec![0.0; points * n],
        }
    }
}

/// Sums that an adjoint adds to.
pub(super) struct AdjointSums<'a> {
    pub(super) parameters: ParameterSums<'a>,
    pub(super) initial_state: &'a mut [f64],
}

/// One trajectory with the cotangents of its observations.
pub(super) struct Adjoint<'a, 'p, B: BatchField, I, C> {
    pub(super) settings: &'a BatchedIntegrator<C>,
    pub(super) field: &'a B,
    pub(super) problem: &'a TrajectoryProblem<'p, B::Condition, I>,
    pub(super) trajectory: &'a StoredTrajectory<B::Kept>,
    /// `[observations, states]`.
    pub(super) cotangents: &'a [f64],
}

impl<B: BatchField, I: Input<f64>, C: StepController + Sync> Adjoint<'_, '_, B, I, C> {
    /// Adds the gradient to `sums`; returns the number of linearised points.
    pub(super) fn run(
        &self,
        sums: &mut AdjointSums<'_>,
        memory: &mut AdjointMemory<B::Block>,
    ) -> usize {
        let (n, condition) = (self.field.state_len(), &self.problem.condition);
        let steps_at_once = (memory.points / self.settings.tableau.stages_with_fsal()).max(1);
        let mut observation = self.problem.observe_s.len();
        memory.transpose.restart(&self.settings.tableau, n);
        let mut last = self.trajectory.steps();
        let mut linearised = 0;
        let mut kept = &self.trajectory.kept[..];
        while last > 0 {
            let steps = last.saturating_sub(steps_at_once)..last;
            last = steps.start;
            let points = self.gather(steps.clone(), memory);
            let own = kept.len().saturating_sub(points * self.field.kept_len());
            let (before, own) = kept.split_at(own);
            kept = before;
            let AdjointMemory { t, y, u, jacobians, block, .. } = memory;
            let at = Points { t: &t[..points], y: &y[..points * n], u };
            self.field.linearise(condition, at, own, jacobians, block);
            // The number of states as a constant keeps the few numbers of a state in registers.
            let recurse = match n {
                1 => Self::recurse::<1>,
                2 => Self::recurse::<2>,
                3 => Self::recurse::<3>,
                4 => Self::recurse::<4>,
                _ => Self::recurse::<0>,
            };
            recurse(self, steps, points, &mut observation, memory);
            let AdjointMemory { t, y, u, w, block, .. } = memory;
            let at = Points { t: &t[..points], y: &y[..points * n], u };
            let w = &w[..points * n];
            self.field.accumulate(condition, at, own, w, &mut sums.parameters, block);
            linearised += points;
        }
        self.field.drain(condition, &mut sums.parameters, &mut memory.block);
        // What is left is observed at the start itself.
        for cotangent in self.cotangents[..observation * n].chunks_exact(n) {
            memory.transpose.observe_state(cotangent);
        }
        for (sum, &y) in sums.initial_state.iter_mut().zip(memory.transpose.state()) {
            *sum += y;
        }
        linearised
    }

    /// Writes the points of a range of steps: of each its first stage (if it restarts), the further
    /// stages, and the FSAL stage (if evaluated).
    fn gather(&self, steps: Range<usize>, memory: &mut AdjointMemory<B::Block>) -> usize {
        let tableau = &self.settings.tableau;
        let (n, m) = (self.field.state_len(), self.field.input_len());
        let trajectory = self.trajectory;
        let mut point = 0;
        for step in steps {
            let (t, t_new) = trajectory.grid.step_s(step);
            let (y, k) = (trajectory.state(step), trajectory.derivatives(step));
            let first = usize::from(!trajectory.grid.is_restart(step));
            for i in first..tableau.stages() + usize::from(trajectory.has_fsal[step]) {
                let (time, side) = tableau.stage_time(i, t, t_new);
                memory.t[point] = time;
                let u = &mut memory.u[point * m..(point + 1) * m];
                self.problem.input.value_into(time, side, u);
                let stage = &mut memory.y[point * n..(point + 1) * n];
                if i < tableau.stages() {
                    combine_into(tableau.row(i), t_new - t, y, k, stage);
                } else {
                    stage.copy_from_slice(trajectory.state(step + 1));
                }
                point += 1;
            }
        }
        point
    }

    /// The transposed steps of a block, from its end to its start, for `N` states, or any number if `N`
    /// is zero. The Jacobians of the points are in `memory`, which gets the cotangents of the points.
    fn recurse<const N: usize>(
        &self,
        steps: Range<usize>,
        points: usize,
        observation: &mut usize,
        memory: &mut AdjointMemory<B::Block>,
    ) {
        let n = if N == 0 { self.field.state_len() } else { N };
        let (tableau, trajectory) = (&self.settings.tableau, self.trajectory);
        let observations = Observations { times_s: self.problem.observe_s };
        let AdjointMemory { jacobians, w, transpose, .. } = memory;
        let mut point = points;
        for step in steps.rev() {
            let (t, t_new) = trajectory.grid.step_s(step);
            let left = *observation;
            *observation = transpose.observe::<N>(t, t_new, observations, self.cotangents, left);
            let (has_fsal, restarts) =
                (trajectory.has_fsal[step], trajectory.grid.is_restart(step));
            // The cotangent of one evaluation is kept for the parameters, and goes back to the state.
            transpose.reverse::<N>(tableau, t_new - t, has_fsal, restarts, |_, k_bar, g| {
                point -= 1;
                w[point * n..(point + 1) * n].copy_from_slice(k_bar);
                let jacobian = &jacobians[point * n * n..(point + 1) * n * n];
                g.fill(0.0);
                for (row, &k) in jacobian.chunks_exact(n).zip(k_bar) {
                    for (g, &j) in g.iter_mut().zip(row) {
                        *g += j * k;
                    }
                }
            });
        }
    }
}
