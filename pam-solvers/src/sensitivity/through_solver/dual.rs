use crate::error::SolveError;
use crate::input::ParametricInput;
use crate::replay::replay;
use crate::save_at::SaveAt;
use crate::sensitivity::{Gradient, GradientMethod, Loss, MethodSetup, NamedMethod, Problem, loss};
use crate::term::Term;
use pam_autodiff::Chunk;
use pam_core::{ParametricField, Scalar};

/// Forward mode by dual numbers with eight derivatives through the replayed solve.
///
/// Cost: one replay, at nine times the price, for every eight numbers to differentiate by. For few
/// numbers, and as a reference that shares nothing with the adjoints. [`DualsThroughSolver`] takes another width.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DualThroughSolver;

/// [`DualThroughSolver`] with `N` derivatives at a time: one replay, at `N + 1` times the price, for every `N` numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DualsThroughSolver<const N: usize>;

impl<C> NamedMethod<C> for DualThroughSolver {
    fn from_setup(_: MethodSetup<C>) -> Self {
        Self
    }
}

impl<F: ParametricField, I: ParametricInput> GradientMethod<F, I> for DualThroughSolver {
    fn name(&self) -> String {
        GradientMethod::<F, I>::name(&DualsThroughSolver::<8>)
    }

    fn value_and_gradient(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        DualsThroughSolver::<8>.value_and_gradient(problem, loss)
    }
}

impl<F, I, const N: usize> GradientMethod<F, I> for DualsThroughSolver<N>
where
    F: ParametricField,
    I: ParametricInput,
{
    fn name(&self) -> String {
        format!("dual numbers through the solver, {N} at a time")
    }

    fn value_and_gradient(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        const { assert!(N > 0, "a dual number has at least one derivative") };
        let (states, grid, mut statistics) = problem.solve_on_grid()?;
        let mut cotangents = Vec::new();
        let value = loss::evaluate(loss, problem.observations_s, &states, &mut cotangents);
        let plain = [&problem.field.parameters(), problem.y0, &problem.input.parameters()].concat();
        let (p, n) = (problem.field.parameter_len(), problem.y0.len());
        let mut numbers: Vec<Chunk<N>> = plain.iter().map(|&x| Chunk::constant(x)).collect();
        let mut parameters = vec![0.0; plain.len()];
        for first in (0..plain.len()).step_by(N) {
            let some = first..(first + N).min(plain.len());
            for i in some.clone() {
                numbers[i] = Chunk::variable(plain[i], i - first);
            }
            let term = Term::new(
                problem.field.with_parameters(&numbers[..p]),
                problem.input.with_parameters(&numbers[p + n..]),
            );
            let save_at = SaveAt::Times(problem.observations_s);
            let tableau = problem.integrator.tableau();
            let solution =
                replay(tableau, &term, &grid, &numbers[p..p + n], save_at).map_err(|e| e.real())?;
            statistics.replayed += grid.steps();
            for (y, w) in solution.states().iter().zip(&cotangents) {
                for (sum, d) in parameters[some.clone()].iter_mut().zip(y.derivatives) {
                    *sum += w * d;
                }
            }
            for i in some {
                numbers[i] = Chunk::constant(plain[i]);
            }
        }
        let input = parameters.split_off(p + n);
        let initial_state = parameters.split_off(p);
        Ok(Gradient { value, parameters, initial_state, input, states, grid, statistics })
    }
}
