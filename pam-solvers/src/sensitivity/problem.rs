use super::{Gradient, GradientMethod, GradientStatistics};
use crate::controller::StepController;
use crate::error::SolveError;
use crate::grid::Grid;
use crate::input::{NoInput, ParametricInput};
use crate::integrator::Integrator;
use crate::observer::StepObserver;
use crate::save_at::SaveAt;
use crate::solution::Solution;
use crate::term::Term;
use pam_core::ParametricField;

/// The map that is differentiated: parameters of field and input and the initial state to the states at
/// the observation times.
pub struct Problem<'a, F, I> {
    /// The vector field `f(t, y, u; p)`.
    pub field: &'a F,
    /// The input `u(t; q)`.
    pub input: &'a I,
    /// Start, s.
    pub t0: f64,
    /// End, s.
    pub t1: f64,
    /// Initial state.
    pub y0: &'a [f64],
    /// The times (s) whose states the loss sees, increasing and inside `[t0, t1]`. They need not be
    /// step ends: inside a step the state is read from the method's interpolant.
    pub observations_s: &'a [f64],
    /// The method, its step control and stops. `&Integrator<C>` fits for any controller.
    pub integrator: &'a Integrator<dyn StepController>,
}

impl<'a, F> Problem<'a, F, NoInput> {
    /// A field without input, from a state at t = 0 to the last observation.
    ///
    /// ```
    /// use pam_core::{VectorField, field_fn};
    /// use pam_autodiff::ByTape;
    /// use pam_solvers::sensitivity::{DiscreteAdjoint, GradientMethod, Problem};
    /// use pam_solvers::{Constant, Integrator, PidController, Tableau};
    ///
    /// // ẏ = −p y + u
    /// let field = field_fn!([0.7], 1 => 1, |_t, y, u, p, dy| dy[0] = u[0] - p[0] * y[0]);
    /// let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-10, 1e-10));
    /// let input = Constant(vec![0.0]);
    /// let problem = Problem::new(&field, &[1.0], &[2.0], &integrator).with_input(&input);
    /// let gradient = DiscreteAdjoint::new(ByTape).value_and_gradient(
    ///     &problem,
    ///     &mut |_: &[f64], states: &[f64], cotangents: &mut [f64]| {
    ///         cotangents[0] = 1.0;
    ///         states[0]
    ///     },
    /// )?;
    /// assert!((gradient.parameters[0] + 2.0 * (-1.4_f64).exp()).abs() < 1e-8);
    /// # Ok::<(), Box<pam_solvers::SolveError<f64>>>(())
    /// ```
    pub fn new(
        field: &'a F,
        y0: &'a [f64],
        observations_s: &'a [f64],
        integrator: &'a Integrator<dyn StepController>,
    ) -> Self {
        let t1 = observations_s.last().copied().unwrap_or(0.0);
        Self { field, input: &NoInput, t0: 0.0, t1, y0, observations_s, integrator }
    }
}

impl<'a, F, I> Problem<'a, F, I> {
    /// The same under an input.
    pub fn with_input<J>(self, input: &'a J) -> Problem<'a, F, J> {
        let Self { field, t0, t1, y0, observations_s, integrator, .. } = self;
        Problem { field, input, t0, t1, y0, observations_s, integrator }
    }
}

impl<F, I> Clone for Problem<'_, F, I> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F, I> Copy for Problem<'_, F, I> {}

impl<'a, F: ParametricField, I: ParametricInput> Problem<'a, F, I> {
    /// Value and gradient of a loss by a method. The loss is a closure `|times_s, states, cotangents|`: it returns the loss
    /// of the states at the observation times (row-major) and writes its derivatives by them. A [`Loss`](super::Loss) of
    /// another type goes to [`value_and_gradient`](GradientMethod::value_and_gradient) of the method.
    ///
    /// # Errors
    /// [`SolveError`] if the request is inconsistent or a solve stops early.
    pub fn gradient(
        &self,
        method: &impl GradientMethod<F, I>,
        mut loss: impl FnMut(&[f64], &[f64], &mut [f64]) -> f64,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        method.value_and_gradient(self, &mut loss)
    }

    /// Field and input as the solver takes them.
    #[must_use]
    pub fn term(&self) -> Term<&'a F, &'a I> {
        Term::new(self.field, self.input)
    }

    /// The states at the observation times; `observer` sees every accepted step.
    pub(super) fn solve<O: StepObserver<f64>>(
        &self,
        observer: &mut O,
    ) -> Result<Solution<f64>, Box<SolveError<f64>>> {
        self.solve_at(self.observations_s, observer)
    }

    /// The states at the observation times and the accepted steps.
    pub(super) fn solve_on_grid(
        &self,
    ) -> Result<(Vec<f64>, Grid, GradientStatistics), Box<SolveError<f64>>> {
        let mut grid = Grid::new();
        grid.restart(self.t0);
        let solution = self.solve(&mut grid)?;
        let statistics = GradientStatistics::of_forward(solution.statistics);
        Ok((solution.into_states(), grid, statistics))
    }

    /// The states at other times.
    pub(super) fn solve_at<O: StepObserver<f64>>(
        &self,
        times_s: &[f64],
        observer: &mut O,
    ) -> Result<Solution<f64>, Box<SolveError<f64>>> {
        let save_at = SaveAt::Times(times_s);
        let Self { integrator, t0, t1, y0, .. } = *self;
        integrator.solve_observed(&self.term(), t0, t1, y0, save_at, observer)
    }
}
