//! L-BFGS.

use super::lbfgs_settings::LbfgsSettings;
use super::line_search::{Evaluate, Line, dot, finite};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// How a step ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StepKind {
    /// The value is lower than before.
    Moved,
    /// The gradient is zero: there is nowhere to go.
    Stationary,
    /// No lower value was found, not even along the gradient: what is left is rounding, or the gradient
    /// is not that of the value.
    Stuck,
    /// The function cannot be evaluated at the point itself.
    Undefined,
}

/// The result of one step of [`Lbfgs`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// How it ended.
    pub kind: StepKind,
    /// Value at the point where it ended; NaN if undefined.
    pub value: f64,
    /// Euclidean norm of the gradient there; NaN if undefined.
    pub gradient_norm: f64,
    /// Euclidean length of the step.
    pub length: f64,
    /// Evaluations that were used.
    pub evaluations: usize,
}

/// L-BFGS in operation (Liu and Nocedal 1989; Nocedal and Wright 2006, algorithms 7.4 and 7.5): the
/// direction `−H ∇f` by the two-loop recursion over the last steps, the length by a line search for the
/// strong Wolfe conditions.
///
/// The state, which can be written and read back, holds value and gradient of the last point so that a
/// step starts without an evaluation. After a change of the function itself (another horizon, another
/// auxiliary damping) these are wrong: see [`invalidate`](Self::invalidate) and
/// [`restart`](Self::restart).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Lbfgs {
    /// Settings.
    pub settings: LbfgsSettings,
    len: usize,
    pairs: VecDeque<Pair>,
    known: Option<Known>,
}

/// A step and what it changed in the gradient.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Pair {
    step: Vec<f64>,
    change: Vec<f64>,
}

/// The function at a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Known {
    at: Vec<f64>,
    value: f64,
    gradient: Vec<f64>,
}

/// Cosine between step and change of gradient below which a pair is not remembered: the recursion
/// divides by it.
const LEAST_CURVATURE: f64 = 1e-10;

impl Lbfgs {
    /// True if it is for so many coordinates.
    #[cfg(feature = "joint")]
    pub(crate) fn fits(&self, len: usize) -> bool {
        let pair = |p: &Pair| p.step.len() == len && p.change.len() == len;
        let known = |k: &Known| k.at.len() == len && k.gradient.len() == len;
        self.len == len && self.pairs.iter().all(pair) && self.known.as_ref().is_none_or(known)
    }

    /// L-BFGS for `len` coordinates.
    #[must_use]
    pub fn new(settings: LbfgsSettings, len: usize) -> Self {
        Self { settings, len, pairs: VecDeque::new(), known: None }
    }

    /// Forgets value and gradient of the last point but not the curvature: for a function that changed
    /// a little.
    pub fn invalidate(&mut self) {
        self.known = None;
    }

    /// Forgets all: for a new function.
    pub fn restart(&mut self) {
        self.invalidate();
        self.pairs.clear();
    }

    /// Moves `at` by one step. Where `evaluate` returns none (a solve that diverged) the value counts as
    /// infinite; so it does where value or gradient are not finite.
    ///
    /// Values never rise. If no lower value is found the memory is emptied, the gradient's own
    /// direction is tried, and at last `at` is left as it was.
    ///
    /// # Panics
    /// If lengths differ.
    pub fn minimise_step(&mut self, at: &mut [f64], evaluate: &mut Evaluate<'_>) -> Outcome {
        assert_eq!(at.len(), self.len);
        let mut evaluations = 0;
        let known = match self.known.take() {
            Some(known) if known.at == at => known,
            _ => {
                evaluations += 1;
                let Some((value, gradient)) = finite(evaluate, at) else {
                    let (value, gradient_norm) = (f64::NAN, f64::NAN);
                    let kind = StepKind::Undefined;
                    return Outcome { kind, value, gradient_norm, length: 0.0, evaluations };
                };
                Known { at: at.to_vec(), value, gradient }
            }
        };
        let (moved, kind) = self.descend(&known, evaluate, &mut evaluations);
        let (length, known) = match moved {
            Some(moved) => {
                let step = difference(&moved.at, &known.at);
                let length = norm(&step);
                self.remember(step, difference(&moved.gradient, &known.gradient));
                at.copy_from_slice(&moved.at);
                (length, moved)
            }
            None => (0.0, known),
        };
        let (value, gradient_norm) = (known.value, norm(&known.gradient));
        self.known = Some(known);
        Outcome { kind, value, gradient_norm, length, evaluations }
    }

    /// The next point, by the quasi-Newton direction or else by the gradient's.
    fn descend(
        &mut self,
        known: &Known,
        evaluate: &mut Evaluate<'_>,
        evaluations: &mut usize,
    ) -> (Option<Known>, StepKind) {
        if known.gradient.iter().all(|g| *g == 0.0) {
            return (None, StepKind::Stationary);
        }
        loop {
            let direction = self.direction(&known.gradient);
            let slope = dot(&direction, &known.gradient);
            let steepest = self.pairs.is_empty();
            let length = norm(&direction);
            if slope < 0.0 && length.is_finite() {
                let line =
                    Line { origin: &known.at, direction: &direction, value: known.value, slope };
                let first = if steepest { self.settings.first_step / length } else { 1.0 };
                let largest = self.settings.largest_step.map_or(f64::INFINITY, |l| l / length);
                let (found, used) = line.search(&self.settings, first, largest, evaluate);
                *evaluations += used;
                if let Some(trial) = found.filter(|t| t.value < known.value) {
                    let at = line.point(trial.step);
                    let moved = Known { at, value: trial.value, gradient: trial.gradient };
                    return (Some(moved), StepKind::Moved);
                }
            }
            if steepest {
                return (None, StepKind::Stuck);
            }
            self.pairs.clear();
        }
    }

    /// `−H g` by the two-loop recursion, with the scale of the last pair as the first guess of H.
    fn direction(&self, gradient: &[f64]) -> Vec<f64> {
        let mut q: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let mut shares = Vec::with_capacity(self.pairs.len());
        for pair in self.pairs.iter().rev() {
            let share = dot(&pair.step, &q) / dot(&pair.step, &pair.change);
            add(&mut q, -share, &pair.change);
            shares.push(share);
        }
        if let Some(Pair { step, change }) = self.pairs.back() {
            let scale = dot(step, change) / dot(change, change);
            q.iter_mut().for_each(|q| *q *= scale);
        }
        for (pair, share) in self.pairs.iter().zip(shares.into_iter().rev()) {
            let other = dot(&pair.change, &q) / dot(&pair.step, &pair.change);
            add(&mut q, share - other, &pair.step);
        }
        q
    }

    fn remember(&mut self, step: Vec<f64>, change: Vec<f64>) {
        if dot(&step, &change) > LEAST_CURVATURE * norm(&step) * norm(&change) {
            while self.pairs.len() >= self.settings.memory.max(1) {
                self.pairs.pop_front();
            }
            self.pairs.push_back(Pair { step, change });
        }
    }
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// `to ← to + factor · from`.
fn add(to: &mut [f64], factor: f64, from: &[f64]) {
    for (t, f) in to.iter_mut().zip(from) {
        *t += factor * f;
    }
}
