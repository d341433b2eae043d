use super::Problem;
use crate::error::SolveError;
use crate::input::ParametricInput;
use pam_core::ParametricField;

/// One number that a solution is differentiated by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Direction {
    /// A parameter of the field, by its index.
    Parameter(usize),
    /// An initial state.
    InitialState(usize),
    /// A parameter of the input.
    Input(usize),
}

/// The gradient's three blocks.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    pub(super) parameters: Vec<f64>,
    pub(super) initial_state: Vec<f64>,
    pub(super) input: Vec<f64>,
}

impl Blocks {
    pub(super) fn zeros<F: ParametricField, I: ParametricInput>(
        problem: &Problem<'_, F, I>,
    ) -> Self {
        Self {
            parameters: vec![0.0; problem.field.parameter_len()],
            initial_state: vec![0.0; problem.y0.len()],
            input: vec![0.0; problem.input.parameter_len()],
        }
    }

    /// The numbers that `problem` has.
    pub(super) fn of<F: ParametricField, I: ParametricInput>(problem: &Problem<'_, F, I>) -> Self {
        Self {
            parameters: problem.field.parameters(),
            initial_state: problem.y0.to_vec(),
            input: problem.input.parameters(),
        }
    }

    pub(super) fn at(&mut self, direction: Direction) -> &mut f64 {
        match direction {
            Direction::Parameter(i) => &mut self.parameters[i],
            Direction::InitialState(i) => &mut self.initial_state[i],
            Direction::Input(i) => &mut self.input[i],
        }
    }

    /// The wanted directions, or all of them in the order of the blocks.
    ///
    /// # Errors
    /// A request that names a number which `problem` does not have.
    pub(super) fn directions<F, I>(
        &self,
        wanted: Option<&[Direction]>,
        problem: &Problem<'_, F, I>,
    ) -> Result<Vec<Direction>, Box<SolveError<f64>>> {
        let (p, n, q) = (self.parameters.len(), self.initial_state.len(), self.input.len());
        let Some(wanted) = wanted else {
            let parameters = (0..p).map(Direction::Parameter);
            let states = (0..n).map(Direction::InitialState);
            return Ok(parameters.chain(states).chain((0..q).map(Direction::Input)).collect());
        };
        let exists = |direction: &Direction| match *direction {
            Direction::Parameter(i) => i < p,
            Direction::InitialState(i) => i < n,
            Direction::Input(i) => i < q,
        };
        match wanted.iter().find(|d| !exists(d)) {
            Some(d) => {
                let why = format!("there is no {d:?} to differentiate by");
                Err(SolveError::request(why, problem.t0, problem.y0))
            }
            None => Ok(wanted.to_vec()),
        }
    }
}
