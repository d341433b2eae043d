//! With which method and steps a cell is solved.

use pam_solvers::{ConstantStep, Integrator, PidController, StepController, Tableau};
use std::sync::Arc;

/// How steps are chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Steps {
    /// Under error control.
    Adaptive {
        /// Relative tolerance.
        rtol: f64,
        /// Absolute tolerance.
        atol: f64,
    },
    /// All of one size.
    Constant {
        /// Size, s.
        step_s: f64,
    },
}

/// A Runge–Kutta method with its steps.
#[derive(Debug, Clone)]
pub struct Solver {
    /// The method.
    pub tableau: Tableau,
    /// How steps are chosen.
    pub steps: Steps,
    /// Largest number of steps of a solve, forward or backward: where it is reached the cell has failed.
    pub max_steps: usize,
    /// Times at which steps end (s), forward and backward.
    pub stops_s: Vec<f64>,
}

impl Solver {
    /// Largest number of steps unless another is set.
    pub const MAX_STEPS: usize = 50_000;

    /// `tableau` under error control with one tolerance, relative and absolute.
    #[must_use]
    pub fn adaptive(tableau: Tableau, tolerance: f64) -> Self {
        Self::new(tableau, Steps::Adaptive { rtol: tolerance, atol: tolerance })
    }

    /// `tableau` with steps of `step_s`.
    #[must_use]
    pub fn constant(tableau: Tableau, step_s: f64) -> Self {
        Self::new(tableau, Steps::Constant { step_s })
    }

    /// A method with its steps.
    #[must_use]
    pub fn new(tableau: Tableau, steps: Steps) -> Self {
        Self { tableau, steps, max_steps: Self::MAX_STEPS, stops_s: Vec::new() }
    }

    /// The solver: one type for all controllers, so that every method is compiled once for a problem.
    #[must_use]
    pub fn integrator(&self) -> Integrator<Arc<dyn StepController>> {
        let controller: Arc<dyn StepController> = match self.steps {
            Steps::Adaptive { rtol, atol } => Arc::new(PidController::new(rtol, atol)),
            Steps::Constant { step_s } => Arc::new(ConstantStep::new(step_s)),
        };
        Integrator::new(self.tableau.clone(), controller)
            .with_max_steps(self.max_steps)
            .with_stops(&self.stops_s)
    }
}
