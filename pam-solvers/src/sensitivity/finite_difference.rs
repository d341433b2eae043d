use super::direction::{Blocks, Direction};
use super::{Gradient, GradientMethod, Loss, MethodSetup, NamedMethod, Problem, loss};
use crate::error::SolveError;
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
    /// Directions of the derivative; all of them if absent. The gradient is 0 in the others.
    pub directions: Option<Vec<Direction>>,
}

impl Default for FiniteDifference<Central> {
    fn default() -> Self {
        Self::new(Central { h: 1e-5 })
    }
}

impl<S> FiniteDifference<S> {
    /// Differences by `scheme`, whose step is relative, with floors of 0.01, in all directions.
    pub fn new(scheme: S) -> Self {
        Self { scheme, floors: [0.01; 3], directions: None }
    }

    /// The same with other floors, for parameters of the field, initial states, parameters of the
    /// input.
    #[must_use]
    pub fn with_floors(mut self, floors: [f64; 3]) -> Self {
        self.floors = floors;
        self
    }

    /// The same in some directions.
    #[must_use]
    pub fn with_directions(mut self, directions: Vec<Direction>) -> Self {
        self.directions = Some(directions);
        self
    }
}

impl<C> NamedMethod<C> for FiniteDifference {
    const PAYS_BY_DIRECTION: bool = true;

    fn from_setup(setup: MethodSetup<C>) -> Self {
        Self { floors: setup.floors, directions: setup.directions, ..Self::default() }
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
        let (states, grid, mut statistics) = problem.solve_on_grid()?;
        let mut cotangents = Vec::new();
        let value = loss::evaluate(loss, problem.observations_s, &states, &mut cotangents);

        let mut numbers = Blocks::of(problem);
        let mut slopes = Blocks::zeros(problem);
        for direction in slopes.directions(self.directions.as_deref(), problem)? {
            let x = *numbers.at(direction);
            let floor = match direction {
                Direction::Parameter(_) => self.floors[0],
                Direction::InitialState(_) => self.floors[1],
                Direction::Input(_) => self.floors[2],
            };
            let scale = x.abs().max(floor);
            let mut failure = None;
            let mut value_at = |z: f64| {
                *numbers.at(direction) = x + z * scale;
                let term = Term::new(
                    problem.field.with_parameters(&numbers.parameters),
                    problem.input.with_parameters(&numbers.input),
                );
                let save_at = SaveAt::Times(problem.observations_s);
                let tableau = problem.integrator.tableau();
                match replay(tableau, &term, &grid, &numbers.initial_state, save_at) {
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
            *slopes.at(direction) = self.scheme.derivative(&mut value_at, 0.0) / scale;
            if let Some(e) = failure {
                return Err(e);
            }
            *numbers.at(direction) = x;
        }
        let Blocks { parameters, initial_state, input } = slopes;
        Ok(Gradient { value, parameters, initial_state, input, states, grid, statistics })
    }
}
