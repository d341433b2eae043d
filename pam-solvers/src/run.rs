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
use crate::stepping;
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
        (t0, t1): (f64, f64),
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
        let tableau = &self.integrator.tableau;
        let controller = &self.integrator.controller;
        let mut t = self.t0;
        self.recorder.start(tableau, t, &self.work.y);
        if t == self.t1 {
            return Ok(self.recorder.finish(t, &self.work));
        }
        self.work.first_stage(self.term, t);
        let mut fresh = true;
        let mut h = match controller.initial_step_s() {
            Some(h) => h,
            None => self.estimate_first_step(),
        };
        let mut history = [1.0, 1.0];
        let mut steps = 0;
        let mut next_stop = 0;
        loop {
            if steps == self.integrator.max_steps {
                let limit = self.integrator.max_steps;
                return Err(self.fail(FailureKind::TooManySteps { limit }, t));
            }
            steps += 1;
            h = h.min(controller.largest_step_s());
            let (stop, jump) = self.stop_after(t, &mut next_stop);
            let ends_at_stop = stepping::reaches(t, h, stop);
            let t_new = if ends_at_stop { stop } else { t + h };
            let taken = t_new - t;
            if !ends_at_stop && taken <= 4.0 * f64::EPSILON * t.abs() {
                return Err(self.fail(FailureKind::StepTooSmall { step_s: h }, t));
            }

            self.work.advance(tableau, self.term, t, t_new);
            let jumps = ends_at_stop && jump;
            let at_end = t_new == self.t1;
            let must_close = controller.tolerances().is_some()
                || !(jumps || at_end)
                || self.recorder.needs_interpolant(t_new)
                || self.observer.needs_closing();
            if must_close {
                self.work.close(tableau, self.term, t_new);
            }
            let mut factor = 1.0;
            if let (Some(tolerances), Some(weights)) = (controller.tolerances(), &tableau.error) {
                self.work.estimate_error(weights, taken);
                let error = tolerances.norm(&self.work.scratch, &self.work.y, &self.work.y_new);
                let order = tableau.embedded_order.unwrap_or(tableau.order - 1) + 1;
                let decision = controller.decide(error, history, order);
                if !decision.accept {
                    self.recorder.solution.statistics.rejected += 1;
                    h = taken * decision.factor;
                    if h <= 4.0 * f64::EPSILON * t.abs() || h < f64::MIN_POSITIVE {
                        let kind = if error.is_finite() {
                            FailureKind::StepTooSmall { step_s: h }
                        } else {
                            FailureKind::NonFinite { step_s: taken }
                        };
                        return Err(self.fail(kind, t));
                    }
                    continue;
                }
                factor = decision.factor;
                history = [error, history[0]];
            }
            if self.work.y_new.iter().any(|v| !v.real().is_finite()) {
                return Err(self.fail(FailureKind::NonFinite { step_s: taken }, t));
            }
            self.recorder.solution.statistics.accepted += 1;
            self.recorder.save_step(tableau, (t, t_new), &mut self.work);
            self.observer.accepted(AcceptedStep { t_new, fresh, y: &self.work.y, k: &self.work.k });

            // A step cut short by a stop says little about the step that the error allows.
            h = if ends_at_stop { h.max(taken * factor) } else { h * factor };
            std::mem::swap(&mut self.work.y, &mut self.work.y_new);
            t = t_new;
            if at_end {
                return Ok(self.recorder.finish(t, &self.work));
            }
            fresh = jumps;
            if jumps {
                self.work.first_stage(self.term, t);
            } else {
                self.work.reuse_closing(tableau);
            }
        }
    }

    /// The next time a step must end, and whether the input jumps there. `next_stop` is a cursor
    /// into the user's stops.
    fn stop_after(&self, t: f64, next_stop: &mut usize) -> (f64, bool) {
        let stops = &self.integrator.stops_s;
        while *next_stop < stops.len() && stops[*next_stop] <= t {
            *next_stop += 1;
        }
        let user = stops.get(*next_stop).copied().unwrap_or(f64::INFINITY);
        let jump = self.term.input.next_jump(t).unwrap_or(f64::INFINITY);
        let stop = user.min(jump).min(self.t1);
        (stop, jump == stop)
    }

    /// First step from an Euler step of trial; see [`stepping::first_step`].
    fn estimate_first_step(&mut self) -> f64 {
        let span = self.t1 - self.t0;
        let Some(tolerances) = self.integrator.controller.tolerances() else { return span };
        let n = self.work.y.len();
        let y = &self.work.y;
        let h0 = stepping::probe_step(tolerances, y, &self.work.k[..n], span);
        self.work.euler_probe(self.term, self.t0, h0);
        for (s, &k) in self.work.scratch.iter_mut().zip(&self.work.k[..n]) {
            *s -= k;
        }
        let (y, k) = (&self.work.y, &self.work.k[..n]);
        let order = self.integrator.tableau.order;
        stepping::first_step(tolerances, y, k, &self.work.scratch, (h0, span), order)
    }

    fn fail(self, kind: FailureKind, t: f64) -> Box<SolveError<S>> {
        self.recorder.fail(kind, t, self.work)
    }
}
