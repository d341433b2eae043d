//! The backward solve, from observation to observation.

use super::adjoint_field::AdjointField;
use super::reversed::ReversedInput;
use crate::controller::StepController;
use crate::error::{FailureKind, SolveError};
use crate::grid::Grid;
use crate::input::ParametricInput;
use crate::integrator::Integrator;
use crate::observer::{AcceptedStep, StepObserver};
use crate::save_at::SaveAt;
use crate::sensitivity::{GradientStatistics, Loss, Problem, loss};
use crate::solution::{DenseSolution, Solution};
use crate::term::Term;
use pam_autodiff::DifferentiableField;
use pam_core::{ParametricField, VectorField};

/// The forward solve of a continuous adjoint.
pub(super) struct Forward {
    pub(super) value: f64,
    pub(super) cotangents: Vec<f64>,
    /// The observed states, kept as a solution for errors to carry.
    pub(super) observed: Solution<f64>,
    pub(super) end: Vec<f64>,
    pub(super) grid: Grid,
    pub(super) dense: Option<DenseSolution<f64>>,
    pub(super) statistics: GradientStatistics,
}

struct DenseRecord {
    grid: Grid,
    dense: Option<DenseSolution<f64>>,
}

impl StepObserver<f64> for DenseRecord {
    fn needs_fsal(&self) -> bool {
        self.dense.is_some()
    }
    fn accepted(&mut self, step: AcceptedStep<'_, f64>) {
        self.grid.accepted(step);
        if let Some(dense) = &mut self.dense {
            dense.push(step.t_new, step.y, step.k);
        }
    }
}

impl Forward {
    /// Solves `problem` and evaluates the loss; keeps the whole solution if `dense`.
    pub(super) fn new<F: ParametricField, I: ParametricInput>(
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
        dense: bool,
    ) -> Result<Self, Box<SolveError<f64>>> {
        let n = problem.y0.len();
        let tableau = problem.integrator.tableau();
        let dense = dense.then(|| DenseSolution::new(tableau, n, problem.t0));
        let mut grid = Grid::new();
        grid.restart(problem.t0);
        let mut record = DenseRecord { grid, dense };
        // The end is where the backward solve starts, whether it is observed or not.
        let mut times = problem.observations_s.to_vec();
        let end_observed = times.last().is_some_and(|&t| t >= problem.t1);
        if !end_observed {
            times.push(problem.t1);
        }
        let solution = problem.solve_at(&times, &mut record)?;
        let mut statistics = GradientStatistics::of_forward(solution.statistics);
        statistics.checkpoint_bytes =
            record.dense.as_ref().map_or(0, |dense| dense.len() * size_of::<f64>());
        let end = solution.last().map_or_else(|| problem.y0.to_vec(), <[f64]>::to_vec);
        let observed = if end_observed { solution } else { solution.without_last() };
        let mut cotangents = Vec::new();
        let value =
            loss::evaluate(loss, problem.observations_s, observed.states(), &mut cotangents);
        let DenseRecord { grid, dense } = record;
        Ok(Self { value, cotangents, observed, end, grid, dense, statistics })
    }
}

/// Carries the backward state `z` from `t1` to `t0` and returns it. The adjoint in it jumps by the
/// cotangents of the observations; `each_segment` sees the solution between two of them. If `restart_state`, the
/// integrated state is set to what was observed.
pub(super) fn solve_backward<F, I, V>(
    problem: &Problem<'_, F, I>,
    backward: &Integrator<dyn StepController + '_>,
    forward: &mut Forward,
    term: &Term<&AdjointField<'_, V, I>, ReversedInput<'_, I>>,
    restart_state: bool,
    save_at: SaveAt<'_>,
    each_segment: &mut dyn FnMut(&Solution<f64>),
) -> Result<Vec<f64>, Box<SolveError<f64>>>
where
    F: ParametricField,
    I: ParametricInput,
    V: DifferentiableField,
{
    let (n, at_lambda) = (problem.y0.len(), term.field.lambda());
    let mut z = vec![0.0; term.field.state_len()];
    z[..at_lambda].copy_from_slice(&forward.end[..at_lambda]);
    let mut t = problem.t1;
    let times = problem.observations_s;
    for o in (0..=times.len()).rev() {
        // The last segment ends at the start of the solve.
        let until = if o == 0 { problem.t0 } else { times[o - 1] };
        if until < t {
            let segment = backward.solve(term, -t, -until, &z, save_at).map_err(|e| {
                Box::new(SolveError {
                    kind: FailureKind::Backward(Box::new(e.kind)),
                    time_s: -e.time_s,
                    state: e.state,
                    partial: forward.observed.clone(),
                })
            })?;
            if let Some(end) = segment.last() {
                z.copy_from_slice(end);
            }
            each_segment(&segment);
            forward.statistics.backward_steps += segment.statistics.accepted;
            forward.statistics.backward_rejected += segment.statistics.rejected;
            if at_lambda > 0 {
                forward.statistics.evaluations += segment.statistics.evaluations;
            }
            t = until;
        }
        if o > 0 {
            let w = &forward.cotangents[(o - 1) * n..o * n];
            for (lambda, w) in z[at_lambda..at_lambda + n].iter_mut().zip(w) {
                *lambda += w;
            }
            if restart_state {
                z[..at_lambda].copy_from_slice(&forward.observed.state(o - 1)[..at_lambda]);
            }
        }
    }
    forward.statistics.vjps = term.field.vjps.get();
    Ok(z)
}
