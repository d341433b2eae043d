//! Fields with set-valued dry friction: sliding, turning, sticking, breaking away.
//!
//! The field ([`DryFriction`]) takes the direction of the motion as an input of its own, so that it is smooth as long as
//! that does not change. Steps are cut where the velocity passes zero and where friction holds no longer; between
//! these instants any Runge–Kutta method and step control do their usual work, with their usual order (Acary and
//! Brogliato, *Numerical Methods for Nonsmooth Dynamical Systems*, 2008, chapter 7). A body that sticks stays where
//! it is, to the last bit.
//!
//! **Derivatives.** The instant `τ` of a switch depends on everything before, `δτ = −δv / f_v⁻`. Steps have fixed lengths, so
//! what a changed instant does to the state is added there, `δy⁺ = δy⁻ + (f⁻ − f⁺) δτ`: the saltation of a
//! discontinuous field (Leine and Nijmeijer, *Dynamics and Bifurcations of Non-Smooth Mechanical Systems*, 2004). Dual
//! numbers and tape variables come through.

mod mode;
mod run;

use crate::controller::StepController;
use crate::error::SolveError;
use crate::input::Input;
use crate::integrator::Integrator;
use crate::request::{check_control, check_term};
use crate::save_at::SaveAt;
use crate::solution::Solution;
use crate::term::Term;
use mode::{InMode, Mode};
use pam_core::{DryFriction, Scalar, VectorField};
use run::StickingRun;

impl<C: StepController + ?Sized> Integrator<C> {
    /// Solves a field with dry friction from `y0` at the first of `times_s` (s, increasing) to the last, and saves the
    /// states at all of them. The input of the term has one variable less than the field takes: not the direction.
    ///
    /// Every saved time ends a step.
    ///
    /// ```
    /// use pam_core::{DryFriction, FieldFn};
    /// use pam_solvers::{InputFn, Integrator, PidController, Tableau, Term};
    ///
    /// // A sledge of unit mass, friction 1, pushed with the force 2 sin t: it breaks away at t = π/6.
    /// let sledge = FieldFn::new(2, 2, |_t, y: &[f64], u: &[f64], dy: &mut [f64]| {
    ///     dy[0] = y[1];
    ///     dy[1] = u[0] - u[1]; // u[1] is the direction
    /// });
    /// let push = InputFn::new(1, |t: f64, u: &mut [f64]| u[0] = 2.0 * t.sin());
    /// let friction = DryFriction { velocity: 1, direction: 1 };
    /// let run = Integrator::new(Tableau::tsit5(), PidController::new(1e-9, 1e-9))
    ///     .solve_sticking(&Term::new(sledge, push), friction, &[0.0, 0.0], &[0.0, 0.5, 2.0])?;
    /// assert_eq!(run.state(1), [0.0, 0.0]);
    /// let from = std::f64::consts::FRAC_PI_6;
    /// let speed = 2.0 * (from.cos() - 2.0_f64.cos()) - (2.0 - from);
    /// assert!((run.state(2)[1] - speed).abs() < 1e-8);
    /// # Ok::<(), Box<pam_solvers::SolveError<f64>>>(())
    /// ```
    ///
    /// # Errors
    /// [`SolveError`] with the partial trajectory if the request is inconsistent, a state becomes non-finite, the step
    /// becomes too small or the number of steps too large.
    pub fn solve_sticking<S, F, I>(
        &self,
        term: &Term<F, I>,
        friction: DryFriction,
        y0: &[S],
        times_s: &[f64],
    ) -> Result<Solution<S>, Box<SolveError<S>>>
    where
        S: Scalar,
        F: VectorField<S>,
        I: Input<S>,
    {
        let [t0, t1] = [times_s.first(), times_s.last()].map(|t| t.copied().unwrap_or(f64::NAN));
        let (states, inputs) = (term.field.state_len(), term.field.input_len());
        let fail = |why| Err(SolveError::request(why, t0, y0));
        if friction.velocity >= states || friction.direction >= inputs {
            return fail(format!(
                "dry friction of state {} with its direction in input {} does not fit a field of {states} states \
                 and {inputs} inputs",
                friction.velocity, friction.direction
            ));
        }
        let in_mode = Term::new(
            InMode { field: &term.field, friction, mode: Mode::Slides(1.0) },
            &term.input,
        );
        let checked = check_term(&in_mode, t0, t1, y0, SaveAt::Times(times_s))
            .and_then(|()| check_control(&self.controller, &self.tableau, y0.len()));
        match checked {
            Err(why) => fail(why),
            Ok(()) => StickingRun::new(self, term, friction, y0, times_s).solve(),
        }
    }
}
