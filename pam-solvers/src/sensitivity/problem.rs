use crate::controller::StepController;
use crate::error::SolveError;
use crate::input::ParametricInput;
use crate::integrator::Integrator;
use crate::observer::StepObserver;
use crate::save_at::SaveAt;
use crate::solution::Solution;
use crate::term::Term;
use pam_core::ParametricField;

/// What is differentiated: the states at the observation times, as a function of the parameters of
/// field and input and of the initial state.
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

impl<F, I> Clone for Problem<'_, F, I> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F, I> Copy for Problem<'_, F, I> {}

impl<'a, F: ParametricField, I: ParametricInput> Problem<'a, F, I> {
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

    /// The states at other times.
    pub(super) fn solve_at<O: StepObserver<f64>>(
        &self,
        times_s: &[f64],
        observer: &mut O,
    ) -> Result<Solution<f64>, Box<SolveError<f64>>> {
        let save_at = SaveAt::Times(times_s);
        let interval = (self.t0, self.t1);
        self.integrator.solve_observed(&self.term(), interval, self.y0, save_at, observer)
    }
}
