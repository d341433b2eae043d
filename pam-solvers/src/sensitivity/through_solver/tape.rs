use crate::error::SolveError;
use crate::input::ParametricInput;
use crate::replay::replay;
use crate::save_at::SaveAt;
use crate::sensitivity::{Gradient, GradientMethod, Loss, MethodSetup, NamedMethod, Problem, loss};
use crate::term::Term;
use pam_autodiff::Tape;
use pam_core::ParametricField;

/// Reverse mode by a tape of the whole replayed solve.
///
/// Nothing of the solver is differentiated by hand, which makes it the reference for the discrete
/// adjoint. Cost: that of a recorded solve and one sweep over it, whatever the number of parameters;
/// memory for every operation of every stage of every step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TapeThroughSolver;

impl<C> NamedMethod<C> for TapeThroughSolver {
    fn from_setup(_: MethodSetup<C>) -> Self {
        Self
    }
}

impl<F: ParametricField, I: ParametricInput> GradientMethod<F, I> for TapeThroughSolver {
    fn name(&self) -> String {
        "tape through the solver".into()
    }

    fn value_and_gradient(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        let (states, grid, mut statistics) = problem.solve_on_grid()?;
        let mut cotangents = Vec::new();
        let value = loss::evaluate(loss, problem.observations_s, &states, &mut cotangents);
        let mut tape = Tape::<f64>::new();
        let parameters = tape.variables(&problem.field.parameters());
        let y0 = tape.variables(problem.y0);
        let input = tape.variables(&problem.input.parameters());
        let solution = tape.record(|| {
            let term = Term::new(
                problem.field.with_parameters(&parameters),
                problem.input.with_parameters(&input),
            );
            let save_at = SaveAt::Times(problem.observations_s);
            replay(problem.integrator.tableau(), &term, &grid, &y0, save_at)
        });
        let solution = solution.map_err(|e| e.real())?;
        statistics.replayed = grid.steps();
        statistics.checkpoint_bytes = tape.bytes();
        let seeds = solution.states().iter().copied().zip(cotangents);
        let derivatives = tape.reverse(seeds);
        let of = |vars: &[_]| vars.iter().map(|&var| derivatives.of(var)).collect();
        Ok(Gradient {
            value,
            parameters: of(&parameters),
            initial_state: of(&y0),
            input: of(&input),
            states,
            grid,
            statistics,
        })
    }
}
