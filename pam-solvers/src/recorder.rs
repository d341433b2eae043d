//! Saves the points of a solve that [`SaveAt`] asks for.

use crate::error::{FailureKind, SolveError};
use crate::save_at::SaveAt;
use crate::solution::{DenseSolution, Solution};
use crate::step::Workspace;
use crate::tableau::Tableau;
use pam_core::Scalar;

/// Fills a [`Solution`] step by step.
pub(crate) struct Recorder<'a, S> {
    save_at: SaveAt<'a>,
    /// Number of `SaveAt::Times` entries that are done.
    saved: usize,
    pub(crate) solution: Solution<S>,
}

impl<'a, S: Scalar> Recorder<'a, S> {
    pub(crate) fn new(save_at: SaveAt<'a>, state_len: usize) -> Self {
        let points = match save_at {
            SaveAt::Times(times) => times.len(),
            SaveAt::End => 1,
            SaveAt::Steps | SaveAt::Dense => 64,
        };
        Self { save_at, saved: 0, solution: Solution::with_capacity(state_len, points) }
    }

    /// Returns `true` if saving the step to `t_new` needs the interpolant.
    pub(crate) fn needs_interpolant(&self, t_new: f64) -> bool {
        match self.save_at {
            SaveAt::Dense => true,
            SaveAt::Times(times) => times.get(self.saved).is_some_and(|&s| s < t_new),
            SaveAt::End | SaveAt::Steps => false,
        }
    }

    /// Saves the initial state `y0` at `t0`, if asked for.
    pub(crate) fn start(&mut self, tableau: &Tableau, t0: f64, y0: &[S]) {
        match self.save_at {
            SaveAt::Times(times) => {
                if times.first() == Some(&t0) {
                    self.solution.push(t0, y0);
                    self.saved = 1;
                }
            }
            SaveAt::Steps => self.solution.push(t0, y0),
            SaveAt::Dense => {
                self.solution.push(t0, y0);
                self.solution.dense = Some(DenseSolution::new(tableau, y0.len(), t0));
            }
            SaveAt::End => {}
        }
    }

    /// Saves the points of the step from `t` to `t_new`.
    pub(crate) fn save_step(
        &mut self,
        tableau: &Tableau,
        t: f64,
        t_new: f64,
        work: &mut Workspace<S>,
    ) {
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
                        tableau.interpolate_into(theta, h, &work.y, &work.k, &mut work.scratch);
                        self.solution.push(s, &work.scratch);
                    }
                    self.saved += 1;
                }
            }
        }
    }

    /// The solution, ended at `t1` with the state in `work`.
    pub(crate) fn finish(mut self, t1: f64, work: &Workspace<S>) -> Solution<S> {
        if self.save_at == SaveAt::End {
            self.solution.push(t1, &work.y);
        }
        self.solution.statistics.evaluations = work.evaluations;
        self.solution
    }

    /// The failure `kind` at `t` with the points saved until then.
    pub(crate) fn fail(
        mut self,
        kind: FailureKind,
        t: f64,
        work: Workspace<S>,
    ) -> Box<SolveError<S>> {
        self.solution.statistics.evaluations = work.evaluations;
        Box::new(SolveError { kind, time_s: t, state: work.y, partial: self.solution })
    }
}
