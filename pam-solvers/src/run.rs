//! The solve loop.

use crate::controller::StepController;
use crate::error::{FailureKind, SolveError};
use crate::input::Input;
use crate::integrator::Integrator;
use crate::observer::{AcceptedStep, StepObserver};
use crate::recorder::Recorder;
use crate::save_at::SaveAt;
use crate::solution::Solution;
use crate::step::Workspace;
use crate::step_control::{FirstStep, StepControl, Stops};
use crate::term::Term;
use pam_core::{Scalar, VectorField};

/// One solve in progress.
pub(crate) struct Run<'a, S, F, I, C: ?Sized, O> {
    integrator: &'a Integrator<C>,
    term: &'a Term<F, I>,
    t0: f64,
    t1: f64,
    work: Workspace<S>,
    recorder: Recorder<'a, S>,
    observer: &'a mut O,
}

impl<'a, S, F, I, C, O> Run<'a, S, F, I, C, O>
where
    S: Scalar,
    F: VectorField<S>,
    I: Input<S>,
    C: StepController + ?Sized,
    O: StepObserver<S>,
{
    /// A solve that has not begun; the request must have been checked.
    pub(crate) fn new(
        integrator: &'a Integrator<C>,
        term: &'a Term<F, I>,
        t0: f64,
        t1: f64,
        y0: &[S],
        save_at: SaveAt<'a>,
        observer: &'a mut O,
    ) -> Self {
        Self {
            integrator,
            term,
            t0,
            t1,
            work: Workspace::new(&integrator.tableau, term, y0),
            recorder: Recorder::new(save_at, y0.len()),
            observer,
        }
    }

    /// Runs to the end.
    pub(crate) fn solve(mut self) -> Result<Solution<S>, Box<SolveError<S>>> {
        let Integrator { tableau, controller, limit, .. } = self.integrator;
        self.recorder.start(tableau, self.t0, &self.work.y);
        if self.t0 == self.t1 {
            return Ok(self.recorder.finish(self.t0, &self.work));
        }
        self.work.first_stage(self.term, self.t0);
        let mut restarts = true;
        let mut control = StepControl::new(self.t0);
        control.h = self.first_step_s();
        let mut next_stop = 0;
        loop {
            let stops = self.stops_after(control.t, &mut next_stop);
            let step = match control.propose(controller, stops, limit) {
                Ok(step) => step,
                Err(kind) => return Err(self.fail(kind, control.t)),
            };
            self.work.advance(tableau, self.term, step.t, step.t_new);
            let interpolates =
                self.recorder.needs_interpolant(step.t_new) || self.observer.needs_fsal();
            if step.needs_fsal(controller.tolerances().is_some(), interpolates) {
                self.work.fsal_stage(tableau, self.term, step.t_new);
            }
            let error = match (controller.tolerances(), &tableau.error) {
                (Some(tolerances), Some(weights)) => {
                    self.work.estimate_error(weights, step.size_s());
                    Some(tolerances.norm(&self.work.scratch, &self.work.y, &self.work.y_new))
                }
                _ => None,
            };
            let judged = control.judge(controller, tableau, &step, error, &self.work.y_new);
            self.recorder.solution.statistics.rejected = control.rejected;
            match judged {
                Ok(true) => {}
                Ok(false) => continue,
                Err(kind) => return Err(self.fail(kind, control.t)),
            }
            self.recorder.solution.statistics.accepted += 1;
            self.recorder.save_step(tableau, step.t, step.t_new, &mut self.work);
            let (y, k) = (&self.work.y, &self.work.k);
            self.observer.accepted(AcceptedStep { t_new: step.t_new, restarts, y, k });
            std::mem::swap(&mut self.work.y, &mut self.work.y_new);
            if step.at_end {
                return Ok(self.recorder.finish(step.t_new, &self.work));
            }
            restarts = step.jumps;
            if restarts {
                self.work.first_stage(self.term, step.t_new);
            } else {
                self.work.reuse_fsal(tableau);
            }
        }
    }

    /// Where a step from `t` must end at the latest. `next_stop` is a cursor into the user's stops.
    fn stops_after(&self, t: f64, next_stop: &mut usize) -> Stops {
        let stops = &self.integrator.stops_s;
        while *next_stop < stops.len() && stops[*next_stop] <= t {
            *next_stop += 1;
        }
        let user = stops.get(*next_stop).copied();
        Stops { jump: self.term.input.next_jump(t), user, end: self.t1 }
    }

    /// The first step to try: given, or from an Euler step of trial (see [`FirstStep`]).
    fn first_step_s(&mut self) -> f64 {
        let Integrator { tableau, controller, .. } = self.integrator;
        let span_s = self.t1 - self.t0;
        if let Some(h) = controller.initial_step_s() {
            return h;
        }
        let Some(tolerances) = controller.tolerances() else { return span_s };
        let first = FirstStep { tolerances, order: tableau.order, span_s };
        let n = self.work.y.len();
        let h0 = first.probe_s(&self.work.y, &self.work.k[..n]);
        self.work.euler_probe(self.term, self.t0, h0);
        for (s, &k) in self.work.scratch.iter_mut().zip(&self.work.k[..n]) {
            *s -= k;
        }
        first.estimate_s(&self.work.y, &self.work.k[..n], &self.work.scratch, h0)
    }

    fn fail(self, kind: FailureKind, t: f64) -> Box<SolveError<S>> {
        self.recorder.fail(kind, t, self.work)
    }
}
