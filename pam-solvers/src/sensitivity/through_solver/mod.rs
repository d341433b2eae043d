//! Automatic differentiation straight through the solver: the replayed solve with other numbers.

mod dual;
mod tape;

pub use dual::DualThroughSolver;
pub use tape::TapeThroughSolver;

use super::{GradientStatistics, Loss, Problem, loss};
use crate::error::SolveError;
use crate::grid::Grid;
use crate::input::ParametricInput;
use pam_core::ParametricField;

/// The solve in plain numbers, before its replay.
struct Plain {
    value: f64,
    states: Vec<f64>,
    cotangents: Vec<f64>,
    grid: Grid,
    statistics: GradientStatistics,
}

impl Plain {
    fn new<F: ParametricField, I: ParametricInput>(
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Self, Box<SolveError<f64>>> {
        let mut grid = Grid::new();
        grid.restart(problem.t0);
        let solution = problem.solve(&mut grid)?;
        let statistics = GradientStatistics::of_forward(solution.statistics);
        let states = solution.into_states();
        let mut cotangents = Vec::new();
        let value = loss::evaluate(loss, problem.observations_s, &states, &mut cotangents);
        Ok(Self { value, states, cotangents, grid, statistics })
    }
}
