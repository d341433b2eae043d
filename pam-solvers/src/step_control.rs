//! Step control of one trajectory: propose a step, accept or reject it, or fail.

use crate::controller::{StepController, Tolerances};
use crate::error::FailureKind;
use crate::step_budget::StepLimit;
use crate::tableau::Tableau;
use pam_core::Scalar;

/// A step this close to a stop, relative to its size, ends at the stop.
const STOP_SLACK: f64 = 1e-6;

/// Time, step size and error history of one trajectory.
///
/// A solve loop calls [`propose`](Self::propose), computes the stages, and calls
/// [`judge`](Self::judge). Single and batched solves use the same arithmetic, so they take the same
/// steps, bit for bit.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct StepControl {
    /// Time reached, s.
    pub(crate) t: f64,
    /// Time of the start, s.
    start: f64,
    /// Size of the next step to try, s.
    pub(crate) h: f64,
    /// Errors of the last two accepted steps in units of the tolerance, the latest first.
    history: [f64; 2],
    /// Steps tried.
    steps: usize,
    /// Steps rejected.
    pub(crate) rejected: usize,
}

/// Where the next step must end at the latest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stops {
    /// The next jump of the input, s.
    pub(crate) jump: Option<f64>,
    /// The next stop asked for, s.
    pub(crate) user: Option<f64>,
    /// End of the solve, s.
    pub(crate) end: f64,
}

/// A step to be tried.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ProposedStep {
    /// Start, s.
    pub(crate) t: f64,
    /// End, s.
    pub(crate) t_new: f64,
    ends_at_stop: bool,
    /// The input jumps at the end of the step.
    pub(crate) jumps: bool,
    /// The solve ends with the step.
    pub(crate) at_end: bool,
}

impl ProposedStep {
    /// Size, s.
    #[inline]
    pub(crate) fn size_s(&self) -> f64 {
        self.t_new - self.t
    }

    /// The FSAL stage of the step is evaluated: the error estimate or the next step needs it, or dense
    /// output (`interpolates`).
    #[inline]
    pub(crate) fn needs_fsal(&self, adaptive: bool, interpolates: bool) -> bool {
        adaptive || interpolates || !(self.jumps || self.at_end)
    }
}

impl StepControl {
    /// A trajectory at its start `t` (s), whose first step is still to be set.
    pub(crate) fn new(t: f64) -> Self {
        Self { t, start: t, history: [1.0, 1.0], ..Self::default() }
    }

    /// The next step to try.
    ///
    /// # Errors
    /// [`FailureKind::TooManySteps`] and [`FailureKind::StepTooSmall`].
    pub(crate) fn propose<C: StepController + ?Sized>(
        &mut self,
        controller: &C,
        stops: Stops,
        limit: &StepLimit,
    ) -> Result<ProposedStep, FailureKind> {
        let most = limit.until((self.t - self.start).abs());
        if self.steps >= most {
            return Err(FailureKind::TooManySteps { limit: most });
        }
        self.steps += 1;
        self.h = self.h.min(controller.largest_step_s());
        let jump = stops.jump.unwrap_or(f64::INFINITY);
        let stop = stops.user.unwrap_or(f64::INFINITY).min(jump).min(stops.end);
        let ends_at_stop = self.t + self.h * (1.0 + STOP_SLACK) >= stop;
        let t_new = if ends_at_stop { stop } else { self.t + self.h };
        let step = ProposedStep {
            t: self.t,
            t_new,
            ends_at_stop,
            jumps: ends_at_stop && jump == stop,
            at_end: t_new == stops.end,
        };
        if !ends_at_stop && step.size_s() <= self.smallest_step_s() {
            return Err(FailureKind::StepTooSmall { step_s: self.h });
        }
        Ok(step)
    }

    /// Accepts a step to `y_new`, goes to its end and returns `true`, or rejects it, shortens the next
    /// step and returns `false`. `error` is the norm of the error estimate in units of the tolerance,
    /// absent for steps without error control.
    ///
    /// # Errors
    /// [`FailureKind::NonFinite`] and [`FailureKind::StepTooSmall`].
    pub(crate) fn judge<S: Scalar, C: StepController + ?Sized>(
        &mut self,
        controller: &C,
        tableau: &Tableau,
        step: &ProposedStep,
        error: Option<f64>,
        y_new: &[S],
    ) -> Result<bool, FailureKind> {
        let taken = step.size_s();
        let mut factor = 1.0;
        if let Some(error) = error {
            let decision = controller.decide(error, self.history, tableau.error_order());
            if !decision.accept {
                self.rejected += 1;
                self.h = taken * decision.factor;
                return if self.h > self.smallest_step_s() && self.h >= f64::MIN_POSITIVE {
                    Ok(false)
                } else if error.is_finite() {
                    Err(FailureKind::StepTooSmall { step_s: self.h })
                } else {
                    Err(FailureKind::NonFinite { step_s: taken })
                };
            }
            factor = decision.factor;
            self.history = [error, self.history[0]];
        }
        if y_new.iter().any(|v| !v.real().is_finite()) {
            return Err(FailureKind::NonFinite { step_s: taken });
        }
        // A step cut short by a stop says little about the step that the error allows.
        self.h = if step.ends_at_stop { self.h.max(taken * factor) } else { self.h * factor };
        self.t = step.t_new;
        Ok(true)
    }

    /// Steps up to this size (s) do not move the time.
    fn smallest_step_s(&self) -> f64 {
        4.0 * f64::EPSILON * self.t.abs()
    }
}

/// Estimate of the first step from the sizes of state, derivative and second derivative.
///
/// Source: E. Hairer, S. P. Nørsett and G. Wanner, *Solving Ordinary Differential Equations I*, 2nd
/// edition, Springer 1993, section II.4.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FirstStep<'a> {
    pub(crate) tolerances: &'a Tolerances,
    /// Order of the method.
    pub(crate) order: usize,
    /// Length of the solve, s.
    pub(crate) span_s: f64,
}

impl FirstStep<'_> {
    /// Size (s) of the Euler step at whose end the field is evaluated, from state `y` and derivative `k`.
    pub(crate) fn probe_s<S: Scalar>(&self, y: &[S], k: &[S]) -> f64 {
        let (d0, d1) = (self.tolerances.norm(y, y, y), self.tolerances.norm(k, y, y));
        let h0 = if d0 < 1e-5 || d1 < 1e-5 { 1e-6 } else { 0.01 * d0 / d1 };
        h0.min(self.span_s)
    }

    /// The first step (s), from the `change` of the derivative over the Euler step of `h0` (s).
    pub(crate) fn estimate_s<S: Scalar>(&self, y: &[S], k: &[S], change: &[S], h0: f64) -> f64 {
        let d1 = self.tolerances.norm(k, y, y);
        let d2 = self.tolerances.norm(change, y, y) / h0;
        let largest = d1.max(d2);
        let h1 = if largest <= 1e-15 {
            (h0 * 1e-3).max(1e-6)
        } else {
            (0.01 / largest).powf(1.0 / self.order as f64)
        };
        let h = h1.min(100.0 * h0);
        if h.is_finite() && h > 0.0 { h.min(self.span_s) } else { h0 }
    }
}
