//! The accepted steps of a solve.

use crate::observer::{AcceptedStep, StepObserver};

/// The accepted steps of a solve: their ends, and where the input jumps.
///
/// The gradient of an adaptive solve is the gradient of the map with these steps frozen;
/// [`replay`](crate::replay()) is that map. [`Integrator::solve_with_grid`] records a grid.
///
/// [`Integrator::solve_with_grid`]: crate::Integrator::solve_with_grid
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Grid {
    /// Step ends, one more than steps.
    times_s: Vec<f64>,
    /// For each step, `true` if it restarts.
    restarts: Vec<bool>,
}

impl Grid {
    /// A grid without steps.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets all steps and starts at `t0`; keeps the memory.
    pub(crate) fn restart(&mut self, t0: f64) {
        self.times_s.clear();
        self.restarts.clear();
        self.times_s.push(t0);
    }

    pub(crate) fn push(&mut self, t_new: f64, restarts: bool) {
        self.times_s.push(t_new);
        self.restarts.push(restarts);
    }

    /// Number of steps.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.restarts.len()
    }

    /// Start of the first step and the ends of all steps, s.
    #[must_use]
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Start and end of step `step`, s.
    ///
    /// # Panics
    /// If there are not that many steps.
    #[must_use]
    pub fn step_s(&self, step: usize) -> (f64, f64) {
        (self.times_s[step], self.times_s[step + 1])
    }

    /// Returns `true` if step `step` restarts: it is the first one, or the input jumps where it starts.
    /// Otherwise its first stage is the FSAL stage of its predecessor.
    ///
    /// # Panics
    /// If there are not that many steps.
    #[must_use]
    pub fn is_restart(&self, step: usize) -> bool {
        self.restarts[step]
    }

    /// The step ends at which the input jumps, s, increasing.
    pub fn jumps_s(&self) -> impl DoubleEndedIterator<Item = f64> + '_ {
        self.times_s
            .iter()
            .zip(&self.restarts)
            .skip(1)
            .filter(|&(_, &restarts)| restarts)
            .map(|(&t, _)| t)
    }
}

impl<S> StepObserver<S> for Grid {
    fn accepted(&mut self, step: AcceptedStep<'_, S>) {
        self.push(step.t_new, step.restarts);
    }
}
