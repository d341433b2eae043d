//! Many trajectories at once.
//!
//! Each thread advances a batch of up to [`width`](BatchedIntegrator::with_width) trajectories: stage by
//! stage, one batched evaluation of the field serves all of them, while each keeps a time, a step size
//! and an error history of its own. A trajectory that ends is replaced by the next one from the queue,
//! so the batch stays full.
//!
//! The adjoint runs along each trajectory alone. All stage states are known by then, so the field is
//! linearised for a block of steps at once, the recursion through time handles the small Jacobians
//! only, and the parameter cotangents of the block are summed at once (see
//! [`BatchField`](pam_autodiff::BatchField)). It is the exact discrete adjoint of the accepted steps:
//! the grid is frozen, an FSAL stage that serves as the first of the next step carries its cotangent
//! back, observations inside a step go through the interpolant.
//!
//! A trajectory's numbers do not depend on the rest of its batch, and sums over trajectories run in the
//! order of the problems, so results are the same bits at any number of threads.

mod adjoint;
mod forward;
mod gradient;
mod members;
mod trajectory;

pub use gradient::{BatchGradient, BatchWorkspace};
pub use trajectory::StoredTrajectory;

use crate::controller::StepController;
use crate::error::FailureKind;
use crate::input::Input;
use crate::request::{Lengths, check_control, check_problem};
use crate::step_budget::{StepBudget, StepLimit};
use crate::tableau::Tableau;
use thiserror::Error;

/// The initial-value problem of one trajectory with its observations.
#[derive(Debug, Clone)]
pub struct TrajectoryProblem<'a, C, I> {
    /// The condition of the trajectory; see [`BatchField`](pam_autodiff::BatchField).
    pub condition: C,
    /// Its input.
    pub input: I,
    /// Start, s.
    pub t0: f64,
    /// End, s.
    pub t1: f64,
    /// Initial state.
    pub y0: Vec<f64>,
    /// Times (s, increasing, within start and end) of the observations.
    pub observe_s: &'a [f64],
}

/// A trajectory that stopped early.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("trajectory {problem}: {}", kind.describe(*time_s))]
pub struct TrajectoryFailure {
    /// Index of the problem.
    pub problem: usize,
    /// Why it stopped.
    pub kind: FailureKind,
    /// The time it had reached, s.
    pub time_s: f64,
}

/// A method and a step controller for many trajectories.
#[derive(Debug, Clone)]
pub struct BatchedIntegrator<C> {
    tableau: Tableau,
    controller: C,
    width: usize,
    block_points: usize,
    limit: StepLimit,
}

impl<C: StepController + Sync> BatchedIntegrator<C> {
    /// A method and a controller; batches of up to 16 trajectories, blocks of 256 points, at most 10 million steps a trajectory.
    pub fn new(tableau: Tableau, controller: C) -> Self {
        Self { tableau, controller, width: 16, block_points: 256, limit: StepLimit::default() }
    }

    /// The largest number of trajectories in the batch of one thread.
    #[must_use]
    pub fn with_width(mut self, width: usize) -> Self {
        self.width = width.max(1);
        self
    }

    /// The number of points that the adjoint linearises at once.
    #[must_use]
    pub fn with_block_points(mut self, points: usize) -> Self {
        self.block_points = points.max(self.tableau.stages_with_fsal());
        self
    }

    /// The largest number of steps of one trajectory, rejected ones included.
    #[must_use]
    pub fn with_max_steps(mut self, max_steps: usize) -> Self {
        self.limit.max_steps = max_steps;
        self
    }

    /// Steps by the time that the solve has come to, besides the largest number of all.
    #[must_use]
    pub fn with_step_budget(mut self, budget: StepBudget) -> Self {
        self.limit.budget = Some(budget);
        self
    }

    /// The method.
    pub fn tableau(&self) -> &Tableau {
        &self.tableau
    }

    fn check<K, I: Input<f64>>(
        &self,
        problem: &TrajectoryProblem<'_, K, I>,
        state_len: usize,
        input_len: usize,
    ) -> Result<(), String> {
        let lengths = Lengths {
            states: state_len,
            inputs: input_len,
            given_inputs: problem.input.input_len(),
        };
        let TrajectoryProblem { t0, t1, y0, observe_s, .. } = problem;
        check_problem(lengths, *t0, *t1, y0, Some(observe_s))?;
        check_control(&self.controller, &self.tableau, state_len)
    }
}
