//! The solve loop with its switches.

use super::mode::{InMode, Mode};
use crate::controller::StepController;
use crate::error::{FailureKind, SolveError};
use crate::input::{Input, Side};
use crate::integrator::Integrator;
use crate::solution::Solution;
use crate::step::Workspace;
use crate::step_control::{ProposedStep, StepControl, Stops};
use crate::term::Term;
use pam_core::{DryFriction, Scalar, VectorField, scalar};

/// First step as a share of the whole time, where the controller names none. Its error control takes over from there.
const FIRST_STEP: f64 = 1e-4;
/// Share of a step to which the instant of a switch is located.
const LOCATED: f64 = 1e-13;
/// Most bisections and secants of a location.
const LOCATIONS: usize = 60;

/// One solve in progress.
pub(super) struct StickingRun<'a, S, F, I, C: ?Sized> {
    integrator: &'a Integrator<C>,
    term: &'a Term<F, I>,
    friction: DryFriction,
    times_s: &'a [f64],
    work: Workspace<S>,
    mode: Mode,
    /// Rates of two modes, for switches.
    rates: [Vec<S>; 2],
    u: Vec<S>,
    scratch: Vec<S>,
    solution: Solution<S>,
}

impl<'a, S, F, I, C> StickingRun<'a, S, F, I, C>
where
    S: Scalar,
    F: VectorField<S>,
    I: Input<S>,
    C: StepController + ?Sized,
{
    /// A solve that has not begun; the request must have been checked.
    pub(super) fn new(
        integrator: &'a Integrator<C>,
        term: &'a Term<F, I>,
        friction: DryFriction,
        y0: &[S],
        times_s: &'a [f64],
    ) -> Self {
        let n = y0.len();
        let in_mode = InMode { field: &term.field, friction, mode: Mode::Sticks };
        let scratch = scalar::zeros(VectorField::<S>::work_len(&in_mode));
        Self {
            work: Workspace::new(integrator.tableau(), &Term::new(in_mode, &term.input), y0),
            u: scalar::zeros(term.input.input_len()),
            scratch,
            mode: Mode::Sticks,
            rates: [scalar::zeros(n), scalar::zeros(n)],
            solution: Solution::with_capacity(n, times_s.len()),
            integrator,
            term,
            friction,
            times_s,
        }
    }

    /// The right-hand side in the present mode.
    fn present(&self) -> Term<InMode<'a, F>, &'a I> {
        let mode = self.mode;
        let field = InMode { field: &self.term.field, friction: self.friction, mode };
        Term::new(field, &self.term.input)
    }

    /// Runs to the end.
    pub(super) fn solve(mut self) -> Result<Solution<S>, Box<SolveError<S>>> {
        let Integrator { tableau, controller, limit, .. } = self.integrator;
        let v = self.friction.velocity;
        let (t0, t1) = (self.times_s[0], self.times_s[self.times_s.len() - 1]);
        self.solution.push(t0, &self.work.y);
        let mut control = StepControl::new(t0);
        control.h = controller.initial_step_s().unwrap_or(FIRST_STEP * (t1 - t0));
        let start = self.work.y[v].real();
        self.mode = if start == 0.0 {
            self.mode_at_rest(t0, Side::Right)
        } else {
            Mode::Slides(start.signum())
        };
        if self.mode == Mode::Sticks {
            self.work.y[v] = S::zero();
        }
        let mut fresh = true;
        let mut saved = 1;
        while saved < self.times_s.len() {
            if fresh {
                if self.mode == Mode::Sticks {
                    self.mode = self.mode_at_rest(control.t, Side::Right);
                }
                self.work.first_stage(&self.present(), control.t);
            }
            let stops = Stops {
                jump: self.term.input.next_jump(control.t),
                user: Some(self.times_s[saved]),
                end: t1,
            };
            let step = match control.propose(controller, stops, limit) {
                Ok(step) => step,
                Err(kind) => return Err(self.fail(kind, control.t)),
            };
            self.work.advance(tableau, &self.present(), step.t, step.t_new);
            self.work.fsal_stage(tableau, &self.present(), step.t_new);
            let error = match (controller.tolerances(), &tableau.error) {
                (Some(tolerances), Some(weights)) => {
                    self.work.estimate_error(weights, step.size_s());
                    Some(tolerances.norm(&self.work.scratch, &self.work.y, &self.work.y_new))
                }
                _ => None,
            };
            let judged = control.judge(controller, tableau, &step, error, &self.work.y_new);
            self.solution.statistics.rejected = control.rejected;
            match judged {
                Ok(true) => {}
                Ok(false) => {
                    fresh = false;
                    continue;
                }
                Err(kind) => return Err(self.fail(kind, step.t)),
            }
            self.solution.statistics.accepted += 1;
            let reached = self.switched(&step);
            fresh = reached.is_some() || step.jumps;
            control.t = reached.unwrap_or(step.t_new);
            std::mem::swap(&mut self.work.y, &mut self.work.y_new);
            if !fresh {
                self.work.reuse_fsal(tableau);
            }
            if control.t >= self.times_s[saved] {
                self.solution.push(self.times_s[saved], &self.work.y);
                saved += 1;
            }
        }
        self.solution.statistics.evaluations = self.work.evaluations;
        Ok(self.solution)
    }

    /// The accepted step up to the switch inside it, if there is one, with the mode after it; the time that is reached.
    fn switched(&mut self, step: &ProposedStep) -> Option<f64> {
        let v = self.friction.velocity;
        let (before, after) = (self.work.y[v].real(), self.work.y_new[v].real());
        match self.mode {
            Mode::Slides(sign) if after * sign > 0.0 => None,
            Mode::Slides(sign) if before * sign > 0.0 => {
                let reached = self.locate(step, [before * sign, after * sign], |run, _| {
                    run.work.y_new[v].real() * sign
                });
                self.turn(reached, sign);
                Some(reached)
            }
            // It did not get away from rest in this step.
            Mode::Slides(_) => {
                let [forwards, backwards] = self.pulls(step.t_new, Side::Left, false);
                if forwards == backwards && after != 0.0 {
                    // Without friction nothing holds it.
                    self.mode = Mode::Slides(after.signum());
                    return Some(step.t_new);
                }
                self.work.y_new[v] = self.deviation(v);
                self.mode = mode_of([forwards, backwards]);
                if self.mode == Mode::Sticks {
                    self.work.y_new[v] = S::zero();
                }
                Some(step.t_new)
            }
            Mode::Sticks => {
                let [forwards, backwards] = self.pulls(step.t_new, Side::Left, false);
                if forwards <= 0.0 && backwards >= 0.0 {
                    return None;
                }
                let sign = if forwards > 0.0 { 1.0 } else { -1.0 };
                let pull = |run: &mut Self, t: f64| {
                    let [forwards, backwards] = run.pulls(t, Side::Left, false);
                    -if sign > 0.0 { forwards } else { -backwards }
                };
                let [forwards_0, backwards_0] = self.pulls(step.t, Side::Right, true);
                let first = -if sign > 0.0 { forwards_0 } else { -backwards_0 };
                let last = -if sign > 0.0 { forwards } else { -backwards };
                let reached = self.locate(step, [first.max(0.0), last], pull);
                self.mode = Mode::Slides(sign);
                Some(reached)
            }
        }
    }

    /// Shortens the step to where a function of its end falls from positive to zero, by the method of Illinois on the
    /// step itself. `ends` are its values at both ends; the step then ends where it is not positive any more.
    fn locate(
        &mut self,
        step: &ProposedStep,
        ends: [f64; 2],
        value: impl Fn(&mut Self, f64) -> f64,
    ) -> f64 {
        let tableau = self.integrator.tableau();
        let term = self.present();
        let (mut low, mut high) = (step.t, step.t_new);
        let [mut at_low, mut at_high] = ends;
        let mut side = 0;
        for _ in 0..LOCATIONS {
            if at_high == 0.0 || high - low <= LOCATED * step.size_s() {
                break;
            }
            let secant = high - (high - low) * at_high / (at_high - at_low);
            let middle = 0.5 * (low + high);
            let t = if secant > low && secant < high { secant } else { middle };
            if t <= low || t >= high {
                break;
            }
            self.work.advance(tableau, &term, step.t, t);
            let here = value(self, t);
            if here > 0.0 {
                (low, at_low) = (t, here);
                if side == 1 {
                    at_high *= 0.5;
                }
                side = 1;
            } else {
                (high, at_high) = (t, here);
                if side == -1 {
                    at_low *= 0.5;
                }
                side = -1;
            }
        }
        self.work.advance(tableau, &term, step.t, high);
        high
    }

    /// The velocity has come to zero at `t` while sliding in direction `sign`: the mode from there on, and what the
    /// derivatives of the instant do to the state.
    fn turn(&mut self, t: f64, sign: f64) {
        let v = self.friction.velocity;
        self.rate(t, Side::Left, Mode::Slides(sign), 0);
        let slowing = self.rates[0][v].real();
        self.mode = self.mode_after(t);
        let deviation = self.deviation(v);
        self.work.y_new[v] = deviation;
        if S::NDERIV > 0 && slowing != 0.0 {
            // `mode_after` has used the rates.
            self.rate(t, Side::Left, Mode::Slides(sign), 0);
            self.rate(t, Side::Left, self.mode, 1);
            let instant = deviation.scaled(-1.0 / slowing);
            let [before, after] = &self.rates;
            for ((y, f), g) in self.work.y_new.iter_mut().zip(before).zip(after) {
                *y += instant.scaled(f.real() - g.real());
            }
        }
        if self.mode == Mode::Sticks {
            self.work.y_new[v] = S::zero();
        }
    }

    /// Derivatives of the velocity at the end of the step.
    fn deviation(&self, velocity: usize) -> S {
        let v = self.work.y_new[velocity];
        v - S::constant(v.real())
    }

    /// The mode of a body at rest at the start of a step.
    fn mode_at_rest(&mut self, t: f64, side: Side) -> Mode {
        mode_of(self.pulls(t, side, true))
    }

    /// The mode of a body at rest at the end of a step.
    fn mode_after(&mut self, t: f64) -> Mode {
        mode_of(self.pulls(t, Side::Left, false))
    }

    /// Accelerations in both directions at the start or the end of a step, were it at rest there.
    fn pulls(&mut self, t: f64, side: Side, at_start: bool) -> [f64; 2] {
        let v = self.friction.velocity;
        if at_start {
            std::mem::swap(&mut self.work.y, &mut self.work.y_new);
        }
        let velocity = std::mem::replace(&mut self.work.y_new[v], S::zero());
        self.rate(t, side, Mode::Slides(1.0), 0);
        self.rate(t, side, Mode::Slides(-1.0), 1);
        self.work.y_new[v] = velocity;
        if at_start {
            std::mem::swap(&mut self.work.y, &mut self.work.y_new);
        }
        [self.rates[0][v].real(), self.rates[1][v].real()]
    }

    /// The rate at the end of the step in a mode.
    fn rate(&mut self, t: f64, side: Side, mode: Mode, to: usize) {
        let field = InMode { field: &self.term.field, friction: self.friction, mode };
        let term = Term::new(field, &self.term.input);
        let (y, rate) = (&self.work.y_new, &mut self.rates[to]);
        term.eval_into(t, side, y, rate, &mut self.u, &mut self.scratch);
        self.work.evaluations += 1;
    }

    fn fail(self, kind: FailureKind, t: f64) -> Box<SolveError<S>> {
        Box::new(SolveError { kind, time_s: t, state: self.work.y, partial: self.solution })
    }
}

/// The mode at rest under accelerations forwards and backwards.
fn mode_of([forwards, backwards]: [f64; 2]) -> Mode {
    if forwards <= 0.0 && backwards >= 0.0 && backwards > forwards {
        Mode::Sticks
    } else if forwards + backwards >= 0.0 {
        Mode::Slides(1.0)
    } else {
        Mode::Slides(-1.0)
    }
}
