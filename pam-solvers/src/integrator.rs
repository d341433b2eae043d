//! The solver: a Runge–Kutta method with a step controller.

use crate::controller::StepController;
use crate::error::SolveError;
use crate::grid::Grid;
use crate::input::Input;
use crate::observer::StepObserver;
use crate::request::{check_control, check_term};
use crate::run::Run;
use crate::save_at::SaveAt;
use crate::solution::Solution;
use crate::step_budget::{StepBudget, StepLimit};
use crate::tableau::Tableau;
use crate::term::Term;
use pam_core::{Scalar, VectorField};

/// A Runge–Kutta method with a step controller; solves any [`Term`].
///
/// `&Integrator<C>` becomes `&Integrator<dyn StepController>` by itself where the type of the
/// controller should not be named.
///
/// ```
/// use pam_core::FieldFn;
/// use pam_solvers::{InputFn, Integrator, PidController, SaveAt, Tableau, Term};
///
/// // ẏ = u(t) − y with u = 1: y = 1 − e^(−t).
/// let field = FieldFn::new(1, 1, |_t, y: &[f64], u: &[f64], dy: &mut [f64]| dy[0] = u[0] - y[0]);
/// let term = Term::new(field, InputFn::new(1, |_t, u: &mut [f64]| u[0] = 1.0));
/// let solver = Integrator::new(Tableau::tsit5(), PidController::new(1e-9, 1e-9)).with_stops(&[0.5]);
/// let solution = solver.solve(&term, 0.0, 2.0, &[0.0], SaveAt::Steps)?;
/// let end = solution.len() - 1;
/// assert!((solution.state(end)[0] - (1.0 - (-2.0_f64).exp())).abs() < 1e-8);
/// assert!(solution.statistics.accepted > 0);
/// # Ok::<(), Box<pam_solvers::SolveError<f64>>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Integrator<C: ?Sized> {
    pub(crate) tableau: Tableau,
    pub(crate) stops_s: Vec<f64>,
    pub(crate) limit: StepLimit,
    // Last, so that a reference to the whole can forget the controller's type.
    pub(crate) controller: C,
}

impl<C: StepController> Integrator<C> {
    /// A method and a controller, no stops, at most 10 million steps.
    pub fn new(tableau: Tableau, controller: C) -> Self {
        Self { tableau, controller, stops_s: Vec::new(), limit: StepLimit::default() }
    }

    /// Times (s, any order) at which a step must end, besides the jumps of the input.
    #[must_use]
    pub fn with_stops(mut self, stops_s: &[f64]) -> Self {
        self.stops_s = stops_s.to_vec();
        self.stops_s.sort_by(f64::total_cmp);
        self
    }

    /// The largest number of steps, rejected ones included.
    #[must_use]
    pub fn with_max_steps(mut self, max_steps: usize) -> Self {
        self.limit.max_steps = max_steps;
        self
    }

    /// Steps by the time that the solve has come to, besides the largest number of all.
    #[must_use]
    pub fn with_step_budget(mut self, budget: StepBudget) -> Self {
        self.limit.budget = Some(budget);
        self
    }
}

impl<C: StepController + ?Sized> Integrator<C> {
    /// The method.
    pub fn tableau(&self) -> &Tableau {
        &self.tableau
    }

    /// Solves `ẏ = f(t, y, u(t))` from `y0` at `t0` to `t1` (s) and saves the points of `save_at`.
    ///
    /// Once memory for the kept points is allocated, a step allocates nothing
    /// ([`SaveAt::Steps`] and [`SaveAt::Dense`] grow with the number of steps).
    ///
    /// # Errors
    /// [`SolveError`] with the partial trajectory if the request is inconsistent, a state becomes
    /// non-finite, the step becomes too small or the number of steps too large.
    pub fn solve<S, F, I>(
        &self,
        term: &Term<F, I>,
        t0: f64,
        t1: f64,
        y0: &[S],
        save_at: SaveAt<'_>,
    ) -> Result<Solution<S>, Box<SolveError<S>>>
    where
        S: Scalar,
        F: VectorField<S>,
        I: Input<S>,
    {
        self.solve_observed(term, t0, t1, y0, save_at, &mut ())
    }

    /// [`solve`](Self::solve) that also writes the accepted steps to `grid`, whose memory is reused.
    /// [`replay`](crate::replay()) runs the same steps again, with any scalar.
    ///
    /// # Errors
    /// As [`solve`](Self::solve); `grid` then holds the steps accepted until the failure.
    pub fn solve_with_grid<S, F, I>(
        &self,
        term: &Term<F, I>,
        t0: f64,
        t1: f64,
        y0: &[S],
        save_at: SaveAt<'_>,
        grid: &mut Grid,
    ) -> Result<Solution<S>, Box<SolveError<S>>>
    where
        S: Scalar,
        F: VectorField<S>,
        I: Input<S>,
    {
        grid.restart(t0);
        self.solve_observed(term, t0, t1, y0, save_at, grid)
    }

    /// [`solve`](Self::solve) that shows every accepted step to `observer`.
    pub(crate) fn solve_observed<S, F, I, O>(
        &self,
        term: &Term<F, I>,
        t0: f64,
        t1: f64,
        y0: &[S],
        save_at: SaveAt<'_>,
        observer: &mut O,
    ) -> Result<Solution<S>, Box<SolveError<S>>>
    where
        S: Scalar,
        F: VectorField<S>,
        I: Input<S>,
        O: StepObserver<S>,
    {
        let checked = check_term(term, t0, t1, y0, save_at)
            .and_then(|()| check_control(&self.controller, &self.tableau, y0.len()));
        if let Err(why) = checked {
            return Err(SolveError::request(why, t0, y0));
        }
        Run::new(self, term, t0, t1, y0, save_at, observer).solve()
    }
}
