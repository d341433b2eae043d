//! The solve loop.

use crate::controller::StepController;
use crate::error::{FailureKind, SolveError};
use crate::input::Input;
use crate::save_at::SaveAt;
use crate::solution::{DenseSolution, Solution};
use crate::step::Workspace;
use crate::tableau::Tableau;
use crate::term::Term;
use pam_core::{Scalar, VectorField};

/// A step this close to a stop, relative to its size, ends at the stop.
const STOP_SLACK: f64 = 1e-6;

/// A Runge–Kutta method with a step controller; solves any [`Term`].
#[derive(Debug, Clone)]
pub struct Integrator<C> {
    tableau: Tableau,
    controller: C,
    stops_s: Vec<f64>,
    max_steps: usize,
}

impl<C: StepController> Integrator<C> {
    /// A method and a controller, no stops, at most 10 million steps.
    pub fn new(tableau: Tableau, controller: C) -> Self {
        Self { tableau, controller, stops_s: Vec::new(), max_steps: 10_000_000 }
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
        self.max_steps = max_steps;
        self
    }

    /// The method.
    pub fn tableau(&self) -> &Tableau {
        &self.tableau
    }

    /// Solves `ẏ = f(t, y, u(t))` from `y0` at `t0` to `t1` (s) and keeps what `save_at` says.
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
        let n = y0.len();
        let points = match save_at {
            SaveAt::Times(times) => times.len(),
            SaveAt::End => 1,
            SaveAt::Steps | SaveAt::Dense => 64,
        };
        let solution = Solution::with_capacity(n, points);
        if let Err(why) = self.check(term, t0, t1, y0, save_at) {
            return Err(Box::new(SolveError {
                kind: FailureKind::Request(why),
                time_s: t0,
                state: y0.to_vec(),
                partial: solution,
            }));
        }
        Run {
            integrator: self,
            term,
            t0,
            t1,
            save_at,
            saved: 0,
            work: Workspace::new(&self.tableau, term, y0),
            solution,
        }
        .solve()
    }

    fn check<S, F, I>(
        &self,
        term: &Term<F, I>,
        t0: f64,
        t1: f64,
        y0: &[S],
        save_at: SaveAt<'_>,
    ) -> Result<(), String>
    where
        S: Scalar,
        F: VectorField<S>,
        I: Input<S>,
    {
        if !(t0.is_finite() && t1.is_finite() && t1 >= t0) {
            return Err(format!("the interval [{t0}, {t1}] s is not ordered and finite"));
        }
        if y0.is_empty() || y0.len() != term.field.state_len() {
            return Err(format!(
                "the field has {} states, the initial state has {}",
                term.field.state_len(),
                y0.len()
            ));
        }
        if let Some(i) = y0.iter().position(|v| !v.real().is_finite()) {
            return Err(format!("initial state {i} is {}", y0[i].real()));
        }
        if term.input.input_len() != term.field.input_len() {
            return Err(format!(
                "the field takes {} inputs, {} are given",
                term.field.input_len(),
                term.input.input_len()
            ));
        }
        if let SaveAt::Times(times) = save_at {
            if times.windows(2).any(|w| w[0].partial_cmp(&w[1]) != Some(std::cmp::Ordering::Less)) {
                return Err("the times to save at must increase".into());
            }
            if times.iter().any(|t| !(t0..=t1).contains(t)) {
                return Err(format!("a time to save at is outside [{t0}, {t1}] s"));
            }
        }
        if let Some(tolerances) = self.controller.tolerances() {
            if self.tableau.error.is_none() {
                return Err(format!(
                    "{} has no error estimate; give it a constant step",
                    self.tableau.name
                ));
            }
            if !tolerances.is_valid() {
                return Err("tolerances must be positive numbers".into());
            }
            if tolerances.state_len().is_some_and(|len| len != y0.len()) {
                return Err("there must be one absolute tolerance for each state".into());
            }
        }
        match self.controller.initial_step_s() {
            Some(h) if !(h.is_finite() && h > 0.0) => {
                Err(format!("a step of {h} s is not positive and finite"))
            }
            _ => Ok(()),
        }
    }
}

/// One solve in progress.
struct Run<'a, S, F, I, C> {
    integrator: &'a Integrator<C>,
    term: &'a Term<F, I>,
    t0: f64,
    t1: f64,
    save_at: SaveAt<'a>,
    /// Number of `SaveAt::Times` entries that are done.
    saved: usize,
    work: Workspace<S>,
    solution: Solution<S>,
}

impl<S, F, I, C> Run<'_, S, F, I, C>
where
    S: Scalar,
    F: VectorField<S>,
    I: Input<S>,
    C: StepController,
{
    fn solve(mut self) -> Result<Solution<S>, Box<SolveError<S>>> {
        let tableau = &self.integrator.tableau;
        let controller = &self.integrator.controller;
        let mut t = self.t0;
        self.save_start();
        if t == self.t1 {
            self.finish();
            return Ok(self.solution);
        }
        self.work.first_stage(self.term, t);
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
            let ends_at_stop = t + h * (1.0 + STOP_SLACK) >= stop;
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
                || self.needs_interpolant(t_new);
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
                    self.solution.statistics.rejected += 1;
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
            self.solution.statistics.accepted += 1;
            self.save_step(t, t_new);

            // A step cut short by a stop says little about the step that the error allows.
            h = if ends_at_stop { h.max(taken * factor) } else { h * factor };
            std::mem::swap(&mut self.work.y, &mut self.work.y_new);
            t = t_new;
            if at_end {
                self.finish();
                return Ok(self.solution);
            }
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

    /// First step from the sizes of state, derivative and second derivative (Hairer, Nørsett and
    /// Wanner, *Solving Ordinary Differential Equations I*, section II.4).
    fn estimate_first_step(&mut self) -> f64 {
        let span = self.t1 - self.t0;
        let Some(tolerances) = self.integrator.controller.tolerances() else { return span };
        let n = self.work.y.len();
        let y = &self.work.y;
        let d0 = tolerances.norm(y, y, y);
        let d1 = tolerances.norm(&self.work.k[..n], y, y);
        let h0 = if d0 < 1e-5 || d1 < 1e-5 { 1e-6 } else { 0.01 * d0 / d1 };
        let h0 = h0.min(span);
        self.work.euler_probe(self.term, self.t0, h0);
        for (s, &k) in self.work.scratch.iter_mut().zip(&self.work.k[..n]) {
            *s -= k;
        }
        let y = &self.work.y;
        let d2 = tolerances.norm(&self.work.scratch, y, y) / h0;
        let largest = d1.max(d2);
        let h1 = if largest <= 1e-15 {
            (h0 * 1e-3).max(1e-6)
        } else {
            (0.01 / largest).powf(1.0 / self.integrator.tableau.order as f64)
        };
        let h = h1.min(100.0 * h0);
        if h.is_finite() && h > 0.0 { h.min(span) } else { h0 }
    }

    fn needs_interpolant(&self, t_new: f64) -> bool {
        match self.save_at {
            SaveAt::Dense => true,
            SaveAt::Times(times) => times.get(self.saved).is_some_and(|&s| s < t_new),
            SaveAt::End | SaveAt::Steps => false,
        }
    }

    fn save_start(&mut self) {
        match self.save_at {
            SaveAt::Times(times) => {
                if times.first() == Some(&self.t0) {
                    self.solution.push(self.t0, &self.work.y);
                    self.saved = 1;
                }
            }
            SaveAt::Steps => self.solution.push(self.t0, &self.work.y),
            SaveAt::Dense => {
                self.solution.push(self.t0, &self.work.y);
                let dense =
                    DenseSolution::new(&self.integrator.tableau, self.work.y.len(), self.t0);
                self.solution.dense = Some(dense);
            }
            SaveAt::End => {}
        }
    }

    /// Keeps what the step from `t` to `t_new` holds.
    fn save_step(&mut self, t: f64, t_new: f64) {
        let work = &mut self.work;
        match self.save_at {
            SaveAt::End => {}
            SaveAt::Steps => self.solution.push(t_new, &work.y_new),
            SaveAt::Dense => {
                self.solution.push(t_new, &work.y_new);
                if let Some(dense) = &mut self.solution.dense {
                    dense.push(t_new, &work.y, &work.k);
                }
            }
            SaveAt::Times(times) => {
                while let Some(&s) = times.get(self.saved).filter(|&&s| s <= t_new) {
                    if s == t_new {
                        self.solution.push(s, &work.y_new);
                    } else {
                        let (theta, h) = ((s - t) / (t_new - t), t_new - t);
                        let tableau = &self.integrator.tableau;
                        tableau.interpolate_into(theta, h, &work.y, &work.k, &mut work.scratch);
                        self.solution.push(s, &work.scratch);
                    }
                    self.saved += 1;
                }
            }
        }
    }

    fn finish(&mut self) {
        if self.save_at == SaveAt::End {
            self.solution.push(self.t1, &self.work.y);
        }
        self.solution.statistics.evaluations = self.work.evaluations;
    }

    fn fail(mut self, kind: FailureKind, t: f64) -> Box<SolveError<S>> {
        self.solution.statistics.evaluations = self.work.evaluations;
        Box::new(SolveError { kind, time_s: t, state: self.work.y, partial: self.solution })
    }
}
