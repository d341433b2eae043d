use super::{Gradient, GradientMethod, GradientStatistics, Loss, Problem, loss};
use crate::error::SolveError;
use crate::grid::Grid;
use crate::input::ParametricInput;
use crate::replay::replay;
use crate::save_at::SaveAt;
use crate::term::Term;
use pam_autodiff::{Central, DifferenceScheme};
use pam_core::ParametricField;

/// Differences of the loss of the replayed solve.
///
/// The steps stay those of the solve at the given numbers; differences of adaptive solves that choose
/// their steps afresh are noise of the size of the tolerance over the difference. Uses only values of the
/// loss, so it checks the loss's cotangents too. Cost: a few solves for every number.
///
/// A number `x` moves by the scheme's step times `max(|x|, floor)`. Choose the floor as the size of a
/// small but noticeable change; central differences are exact to about `ε^(2/3) ≈ 4e-11` of the scale
/// of the motion at best.
#[derive(Debug, Clone, PartialEq)]
pub struct FiniteDifference<S = Central> {
    /// The scheme; its step is relative.
    pub scheme: S,
    /// Smallest scale of parameters of the field, of initial states, and of parameters of the input.
    pub floors: [f64; 3],
    /// The parameters of the field to differentiate by, in increasing order; the gradient is 0 for all
    /// others. All, if absent.
    pub parameters: Option<Vec<usize>>,
}

impl Default for FiniteDifference<Central> {
    fn default() -> Self {
        Self::new(Central { h: 1e-5 })
    }
}

impl<S> FiniteDifference<S> {
    /// Differences by `scheme`, whose step is relative, with floors of 0.01, for all parameters.
    pub fn new(scheme: S) -> Self {
        Self { scheme, floors: [0.01; 3], parameters: None }
    }

    /// The same with other floors, for parameters of the field, initial states, parameters of the
    /// input.
    #[must_use]
    pub fn with_floors(mut self, floors: [f64; 3]) -> Self {
        self.floors = floors;
        self
    }

    /// The same for some of the parameters of the field.
    #[must_use]
    pub fn with_parameters(mut self, parameters: Vec<usize>) -> Self {
        self.parameters = Some(parameters);
        self
    }
}

impl<F, I, S> GradientMethod<F, I> for FiniteDifference<S>
where
    F: ParametricField,
    I: ParametricInput,
    S: DifferenceScheme,
{
    fn name(&self) -> String {
        format!("finite difference, {}", self.scheme.name())
    }

    fn value_and_gradient(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        let mut grid = Grid::new();
        grid.restart(problem.t0);
        let solution = problem.solve(&mut grid)?;
        let mut statistics = GradientStatistics::of_forward(solution.statistics);
        let states = solution.into_states();
        let mut cotangents = Vec::new();
        let value = loss::evaluate(loss, problem.observations_s, &states, &mut cotangents);

        let mut numbers = Numbers {
            parameters: problem.field.parameters(),
            y0: problem.y0.to_vec(),
            input: problem.input.parameters(),
        };
        let wanted = match &self.parameters {
            Some(some) => some.clone(),
            None => (0..numbers.parameters.len()).collect(),
        };
        if let Some(i) = wanted.iter().find(|&&i| i >= numbers.parameters.len()) {
            let why = format!("there is no parameter {i} to differentiate by");
            return Err(SolveError::request(why, problem.t0, problem.y0));
        }
        let mut failure = None;
        let mut derivative = |block: Block, i: usize| {
            let x = numbers.block(block)[i];
            let scale = x.abs().max(self.floors[block as usize]);
            let mut value_at = |z: f64| {
                numbers.block(block)[i] = x + z * scale;
                let term = Term::new(
                    problem.field.with_parameters(&numbers.parameters),
                    problem.input.with_parameters(&numbers.input),
                );
                let save_at = SaveAt::Times(problem.observations_s);
                let tableau = problem.integrator.tableau();
                match replay(tableau, &term, &grid, &numbers.y0, save_at) {
                    Ok(solution) => {
                        statistics.evaluations += solution.statistics.evaluations;
                        statistics.replayed += grid.steps();
                        let (times, states) = (problem.observations_s, solution.states());
                        loss::evaluate(loss, times, states, &mut cotangents)
                    }
                    Err(e) => {
                        failure = Some(e);
                        f64::NAN
                    }
                }
            };
            let slope = self.scheme.derivative(&mut value_at, 0.0) / scale;
            numbers.block(block)[i] = x;
            slope
        };
        let mut parameters = vec![0.0; problem.field.parameter_len()];
        for i in wanted {
            parameters[i] = derivative(Block::Parameters, i);
        }
        let initial_state =
            (0..problem.y0.len()).map(|i| derivative(Block::InitialState, i)).collect();
        let input =
            (0..problem.input.parameter_len()).map(|i| derivative(Block::Input, i)).collect();
        match failure {
            Some(e) => Err(e),
            None => {
                Ok(Gradient { value, parameters, initial_state, input, states, grid, statistics })
            }
        }
    }
}

#[derive(Clone, Copy)]
enum Block {
    Parameters,
    InitialState,
    Input,
}

/// Everything that a solution is differentiated by.
struct Numbers {
    parameters: Vec<f64>,
    y0: Vec<f64>,
    input: Vec<f64>,
}

impl Numbers {
    fn block(&mut self, block: Block) -> &mut [f64] {
        match block {
            Block::Parameters => &mut self.parameters,
            Block::InitialState => &mut self.y0,
            Block::Input => &mut self.input,
        }
    }
}
