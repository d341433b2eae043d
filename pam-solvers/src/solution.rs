//! Solutions.

use crate::tableau::Tableau;
use pam_core::Scalar;

/// Counts of a solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Statistics {
    /// Accepted steps.
    pub accepted: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Evaluations of the vector field.
    pub evaluations: usize,
}

/// Saved times and states of a solve.
#[derive(Debug, Clone)]
pub struct Solution<S> {
    state_len: usize,
    times_s: Vec<f64>,
    states: Vec<S>,
    /// Steps and evaluations.
    pub statistics: Statistics,
    /// The continuous solution, if it was asked for.
    pub dense: Option<DenseSolution<S>>,
}

impl<S: Scalar> Solution<S> {
    pub(crate) fn with_capacity(state_len: usize, points: usize) -> Self {
        Self {
            state_len,
            times_s: Vec::with_capacity(points),
            states: Vec::with_capacity(points * state_len),
            statistics: Statistics::default(),
            dense: None,
        }
    }

    pub(crate) fn push(&mut self, t: f64, y: &[S]) {
        self.times_s.push(t);
        self.states.extend_from_slice(y);
    }

    /// Number of saved points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.times_s.len()
    }

    /// Returns `true` if no point was saved.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.times_s.is_empty()
    }

    /// The saved times, s.
    #[must_use]
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// The state at the saved point `index`.
    #[must_use]
    pub fn state(&self, index: usize) -> &[S] {
        &self.states[index * self.state_len..(index + 1) * self.state_len]
    }

    /// All saved states, point by point.
    #[must_use]
    pub fn states(&self) -> &[S] {
        &self.states
    }

    /// Saved points and counts in plain numbers, without the continuous solution.
    pub(crate) fn real(&self) -> Solution<f64> {
        Solution {
            state_len: self.state_len,
            times_s: self.times_s.clone(),
            states: self.states.iter().map(|v| v.real()).collect(),
            statistics: self.statistics,
            dense: None,
        }
    }

    pub(crate) fn without_last(mut self) -> Self {
        self.times_s.pop();
        self.states.truncate(self.times_s.len() * self.state_len);
        self
    }

    pub(crate) fn into_states(self) -> Vec<S> {
        self.states
    }

    /// The last saved state, if any.
    #[must_use]
    pub fn last(&self) -> Option<&[S]> {
        (!self.is_empty()).then(|| self.state(self.len() - 1))
    }

    /// One state variable over all saved points.
    pub fn component(&self, index: usize) -> impl Iterator<Item = S> + '_ {
        self.states.iter().skip(index).step_by(self.state_len).copied()
    }
}

/// A solution that can be evaluated at any time of its interval,
/// `y(t_n + θ h) = y_n + h Σ b_i(θ) k_i`.
#[derive(Debug, Clone)]
pub struct DenseSolution<S> {
    tableau: Tableau,
    state_len: usize,
    /// Step ends, one more than steps.
    times_s: Vec<f64>,
    /// State at the start of each step.
    starts: Vec<S>,
    /// Stage derivatives of each step, the FSAL stage last.
    stages: Vec<S>,
}

impl<S: Scalar> DenseSolution<S> {
    pub(crate) fn new(tableau: &Tableau, state_len: usize, t0: f64) -> Self {
        Self {
            tableau: tableau.clone(),
            state_len,
            times_s: vec![t0],
            starts: Vec::new(),
            stages: Vec::new(),
        }
    }

    pub(crate) fn push(&mut self, t1: f64, y0: &[S], stages: &[S]) {
        self.times_s.push(t1);
        self.starts.extend_from_slice(y0);
        self.stages.extend_from_slice(stages);
    }

    /// The times at which steps begin and end, s.
    #[must_use]
    pub fn grid_s(&self) -> &[f64] {
        &self.times_s
    }

    /// The state at time `t` (s), or `None` outside the interval of the solve.
    #[must_use]
    pub fn at(&self, t: f64) -> Option<Vec<S>> {
        let mut y = vec![S::zero(); self.state_len];
        self.at_into(t, &mut y).then_some(y)
    }

    /// Writes the state at time `t` (s) to `y` and returns `true`, or `false` outside the interval of
    /// the solve. Allocates nothing.
    pub fn at_into(&self, t: f64, y: &mut [S]) -> bool {
        let steps = self.times_s.len() - 1;
        if steps == 0 || !(self.times_s[0]..=self.times_s[steps]).contains(&t) {
            return false;
        }
        let step = self.times_s.partition_point(|&s| s <= t).clamp(1, steps) - 1;
        let (t0, t1) = (self.times_s[step], self.times_s[step + 1]);
        let n = self.state_len;
        let width = n * self.tableau.stages_with_fsal();
        self.tableau.interpolate_into(
            (t - t0) / (t1 - t0),
            t1 - t0,
            &self.starts[step * n..(step + 1) * n],
            &self.stages[step * width..(step + 1) * width],
            y,
        );
        true
    }

    /// Number of scalars it holds.
    pub(crate) fn len(&self) -> usize {
        self.starts.len() + self.stages.len()
    }
}
