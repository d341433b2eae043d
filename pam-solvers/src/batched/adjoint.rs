//! The exact discrete adjoint of one trajectory, block by block from its end.

use super::{BatchedIntegrator, StoredTrajectory, TrajectoryProblem};
use crate::controller::StepController;
use crate::input::{Input, Side};
use crate::step::{combine_into, node};
use crate::tableau::{InterpolantTable, Tableau};
use pam_autodiff::BatchField;
use pam_autodiff::batch::ParameterSums;
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
    /// Cotangents of a step's derivatives.
    k: Vec<f64>,
    /// Cotangent of the state at the end of a step; at last that of the initial state.
    y_end: Vec<f64>,
    y_start: Vec<f64>,
    /// Cotangent of a first derivative that is the closing one of the step before.
    carry: Vec<f64>,
    product: Vec<f64>,
    interpolant: InterpolantTable,
    /// Interpolation weights of one observation.
    weights: Vec<f64>,
}

impl<M> AdjointMemory<M> {
    pub(super) fn new<B: BatchField<Block = M>>(
        field: &B,
        tableau: &Tableau,
        points: usize,
    ) -> Self {
        let (n, m) = (field.state_len(), field.input_len());
        let interpolant = InterpolantTable::new(tableau);
        Self {
            weights: vec![0.0; interpolant.len()],
            interpolant,
            block: field.block(points),
            points,
            t: vec![0.0; points],
            y: vec![0.0; points * n],
            u: vec![0.0; points * m],
            jacobians: vec![0.0; points * n * n],
            w: vec![0.0; points * n],
            k: vec![0.0; tableau.derivatives() * n],
            y_end: vec![0.0; n],
            y_start: vec![0.0; n],
            carry: vec![0.0; n],
            product: vec![0.0; n],
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
        let n = self.field.state_len();
        let steps_at_once = (memory.points / self.settings.tableau.derivatives()).max(1);
        let mut observation = self.problem.observe_s.len();
        memory.y_end.fill(0.0);
        memory.carry.fill(0.0);
        let mut last = self.trajectory.steps();
        let mut linearised = 0;
        let mut kept = &self.trajectory.kept[..];
        while last > 0 {
            let steps = last.saturating_sub(steps_at_once)..last;
            last = steps.start;
            let points = self.gather(steps.clone(), memory);
            let AdjointMemory { t, y, u, jacobians, block, .. } = memory;
            let (t, y) = (&t[..points], &y[..points * n]);
            let own = kept.len().saturating_sub(points * self.field.kept_len());
            let (before, own) = kept.split_at(own);
            kept = before;
            self.field.linearise(&self.problem.condition, t, y, u, own, jacobians, block);
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
            self.field.accumulate(
                &self.problem.condition,
                &t[..points],
                &y[..points * n],
                u,
                own,
                &w[..points * n],
                &mut sums.parameters,
                block,
            );
            linearised += points;
        }
        self.field.drain(&self.problem.condition, &mut sums.parameters, &mut memory.block);
        // What is left is observed at the start itself.
        for cotangent in self.cotangents[..observation * n].chunks_exact(n) {
            add(&mut memory.y_end, cotangent);
        }
        add(sums.initial_state, &memory.y_end);
        linearised
    }

    /// Writes the points of a range of steps: for each its first stage (if evaluated afresh), the
    /// further stages, and the closing derivative (if evaluated).
    fn gather(&self, steps: Range<usize>, memory: &mut AdjointMemory<B::Block>) -> usize {
        let tableau = &self.settings.tableau;
        let (n, m) = (self.field.state_len(), self.field.input_len());
        let trajectory = self.trajectory;
        let mut point = 0;
        for step in steps {
            let (t0, t1) = (trajectory.times_s()[step], trajectory.times_s()[step + 1]);
            let (h, y0) = (t1 - t0, trajectory.state(step));
            let k = trajectory.derivatives(step);
            let mut place = |t: f64, side: Side| {
                memory.t[point] = t;
                self.problem.input.value_into(t, side, &mut memory.u[point * m..(point + 1) * m]);
                point += 1;
                (point - 1) * n..point * n
            };
            if trajectory.fresh[step] {
                let range = place(t0, Side::Right);
                memory.y[range].copy_from_slice(y0);
            }
            for i in 1..tableau.stages() {
                let (t, side) = node(tableau.c[i], t0, t1);
                let range = place(t, side);
                combine_into(&tableau.a[i], h, y0, k, &mut memory.y[range]);
            }
            if trajectory.closed[step] {
                let range = place(t1, Side::Left);
                memory.y[range].copy_from_slice(trajectory.state(step + 1));
            }
        }
        point
    }

    /// The recursion through the steps of a block, from its end to its start, for `N` states, or any
    /// number if `N` is zero.
    fn recurse<const N: usize>(
        &self,
        steps: Range<usize>,
        points: usize,
        observation: &mut usize,
        memory: &mut AdjointMemory<B::Block>,
    ) {
        let tableau = &self.settings.tableau;
        let n = if N == 0 { self.field.state_len() } else { N };
        let (s, times) = (tableau.stages(), self.trajectory.times_s());
        let observe_s = self.problem.observe_s;
        let AdjointMemory {
            jacobians,
            w,
            k,
            y_end,
            y_start,
            carry,
            product,
            interpolant,
            weights,
            ..
        } = memory;
        let mut point = points;
        for step in steps.rev() {
            let (t0, t1) = (times[step], times[step + 1]);
            let h = t1 - t0;
            y_start.fill(0.0);
            k[..s * n].fill(0.0);
            k[s * n..].copy_from_slice(carry);
            while *observation > 0 && observe_s[*observation - 1] > t0 {
                *observation -= 1;
                let cotangent = &self.cotangents[*observation * n..(*observation + 1) * n];
                let t = observe_s[*observation];
                if t == t1 {
                    add(y_end, cotangent);
                    continue;
                }
                add(y_start, cotangent);
                interpolant.weights_into((t - t0) / h, h, weights);
                for (k, weight) in k.chunks_exact_mut(n).zip(&*weights) {
                    for (k, &c) in k.iter_mut().zip(cotangent) {
                        *k += weight * c;
                    }
                }
            }
            // One evaluation's share: its cotangent is kept for the parameters, and goes back to the
            // state it was evaluated at.
            let mut pull = |k: &[f64], product: &mut [f64]| {
                point -= 1;
                w[point * n..(point + 1) * n].copy_from_slice(k);
                let jacobian = &jacobians[point * n * n..(point + 1) * n * n];
                product.fill(0.0);
                for (row, &k) in jacobian.chunks_exact(n).zip(k) {
                    for (p, &j) in product.iter_mut().zip(row) {
                        *p += j * k;
                    }
                }
            };
            if self.trajectory.closed[step] {
                pull(&k[s * n..], product);
                add(y_end, product);
            }
            for (k, &b) in k.chunks_exact_mut(n).zip(&tableau.b) {
                for (k, &y) in k.iter_mut().zip(&*y_end) {
                    *k += h * b * y;
                }
            }
            add(y_start, y_end);
            for i in (1..s).rev() {
                let (before, at) = k.split_at_mut(i * n);
                pull(&at[..n], product);
                add(y_start, product);
                for (k, &a) in before.chunks_exact_mut(n).zip(&tableau.a[i]) {
                    if a != 0.0 {
                        for (k, &p) in k.iter_mut().zip(&*product) {
                            *k += h * a * p;
                        }
                    }
                }
            }
            if self.trajectory.fresh[step] {
                pull(&k[..n], product);
                add(y_start, product);
                carry.fill(0.0);
            } else {
                carry.copy_from_slice(&k[..n]);
            }
            y_end.copy_from_slice(y_start);
        }
    }
}

fn add(sum: &mut [f64], value: &[f64]) {
    for (s, &v) in sum.iter_mut().zip(value) {
        *s += v;
    }
}
