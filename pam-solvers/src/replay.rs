//! The steps of an earlier solve once more, with any scalar.

use crate::error::{FailureKind, SolveError};
use crate::grid::Grid;
use crate::input::Input;
use crate::recorder::Recorder;
use crate::request::check_term;
use crate::save_at::SaveAt;
use crate::solution::Solution;
use crate::step::Workspace;
use crate::tableau::Tableau;
use crate::term::Term;
use pam_core::{Scalar, VectorField};

/// Takes exactly the steps of `grid`: `ẏ = f(t, y, u(t))` from `y0`, without error control.
///
/// With the term and initial state of the solve that made the grid, the result is that solve's, bit for
/// bit (in `f64`; dual numbers may round divisions differently). With other numbers it is the map whose
/// derivative is *the* gradient of an adaptive solve: finite differences, dual numbers and tape
/// variables all go through here. The input must jump where it did, which its parameters cannot change.
///
/// `statistics` count the accepted steps and the evaluations of the replay; nothing is rejected.
///
/// # Errors
/// [`SolveError`] if the request is inconsistent or a state becomes non-finite.
pub fn replay<S, F, I>(
    tableau: &Tableau,
    term: &Term<F, I>,
    grid: &Grid,
    y0: &[S],
    save_at: SaveAt<'_>,
) -> Result<Solution<S>, Box<SolveError<S>>>
where
    S: Scalar,
    F: VectorField<S>,
    I: Input<S>,
{
    let (Some(&t0), Some(&t1)) = (grid.times_s().first(), grid.times_s().last()) else {
        return Err(SolveError::request("the grid was never recorded".into(), 0.0, y0));
    };
    if let Err(why) = check_term(term, t0, t1, y0, save_at) {
        return Err(SolveError::request(why, t0, y0));
    }
    let mut recorder = Recorder::new(save_at, y0.len());
    recorder.start(tableau, t0, y0);
    let mut replay = Replay::new(tableau, term, grid, y0);
    replay.begin();
    for step in 0..grid.steps() {
        let (t, t_new) = grid.step_s(step);
        replay.take(step);
        if recorder.needs_interpolant(t_new) {
            replay.fsal_stage(step);
        }
        if replay.work.y_new.iter().any(|v| !v.real().is_finite()) {
            let kind = FailureKind::NonFinite { step_s: t_new - t };
            return Err(recorder.fail(kind, t, replay.work));
        }
        recorder.solution.statistics.accepted += 1;
        recorder.save_step(tableau, t, t_new, &mut replay.work);
        replay.proceed(step);
    }
    Ok(recorder.finish(t1, &replay.work))
}

/// The steps of a grid, one call each, from any point of it.
pub(crate) struct Replay<'a, S, F, I> {
    tableau: &'a Tableau,
    term: &'a Term<F, I>,
    grid: &'a Grid,
    pub(crate) work: Workspace<S>,
    has_fsal: bool,
}

impl<'a, S, F, I> Replay<'a, S, F, I>
where
    S: Scalar,
    F: VectorField<S>,
    I: Input<S>,
{
    pub(crate) fn new(
        tableau: &'a Tableau,
        term: &'a Term<F, I>,
        grid: &'a Grid,
        y0: &[S],
    ) -> Self {
        let work = Workspace::new(tableau, term, y0);
        Self { tableau, term, grid, work, has_fsal: false }
    }

    /// Evaluates the first stage of the first step.
    pub(crate) fn begin(&mut self) {
        if self.grid.steps() > 0 {
            self.work.first_stage(self.term, self.grid.times_s()[0]);
        }
    }

    /// Goes to the start of a step whose state and first derivative are known.
    pub(crate) fn restore(&mut self, y: &[S], k1: &[S]) {
        self.work.y.copy_from_slice(y);
        self.work.k[..y.len()].copy_from_slice(k1);
        self.has_fsal = false;
    }

    /// Stages and end state of step `step`, whose start is at hand.
    pub(crate) fn take(&mut self, step: usize) {
        let (t, t_new) = self.grid.step_s(step);
        self.work.advance(self.tableau, self.term, t, t_new);
        self.has_fsal = false;
    }

    /// The FSAL stage of the step just taken.
    pub(crate) fn fsal_stage(&mut self, step: usize) {
        if !self.has_fsal {
            self.work.fsal_stage(self.tableau, self.term, self.grid.step_s(step).1);
            self.has_fsal = true;
        }
    }

    /// Goes from the step just taken to the start of the next one, if there is one.
    pub(crate) fn proceed(&mut self, step: usize) {
        let next = step + 1;
        let last = next == self.grid.steps();
        if !last && !self.grid.is_restart(next) {
            self.fsal_stage(step);
            self.work.reuse_fsal(self.tableau);
        }
        std::mem::swap(&mut self.work.y, &mut self.work.y_new);
        if !last && self.grid.is_restart(next) {
            self.work.first_stage(self.term, self.grid.step_s(next).0);
        }
        self.has_fsal = false;
    }
}
