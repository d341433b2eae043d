//! Why a solve stopped, and what it had reached.

use crate::solution::Solution;
use pam_core::Scalar;
use std::fmt;

/// Why a solve stopped early.
#[derive(Debug, Clone, PartialEq)]
pub enum FailureKind {
    /// The request itself is inconsistent; nothing was computed.
    Request(String),
    /// A state became infinite or NaN in a step of this size (s).
    NonFinite {
        /// Step size, s.
        step_s: f64,
    },
    /// The error control asked for a step (s) that is too small to move the time.
    StepTooSmall {
        /// Step size, s.
        step_s: f64,
    },
    /// The backward solve of a continuous adjoint stopped early for this reason. `time_s` is the time
    /// it had come back to, `state` the backward state there (adjoint and sums, after the state itself
    /// where that is integrated back too), `partial` the states observed by the forward solve.
    Backward(Box<FailureKind>),
    /// The allowed number of steps is used up.
    TooManySteps {
        /// The limit.
        limit: usize,
    },
}

/// A solve that stopped early, with the trajectory up to there.
#[derive(Clone)]
pub struct SolveError<S> {
    /// Why it stopped.
    pub kind: FailureKind,
    /// The time it had reached, s.
    pub time_s: f64,
    /// The last finite state.
    pub state: Vec<S>,
    /// Everything saved until then.
    pub partial: Solution<S>,
}

impl<S: Scalar> SolveError<S> {
    /// An inconsistent request: nothing was computed.
    pub(crate) fn request(why: String, t0: f64, y0: &[S]) -> Box<Self> {
        Box::new(Self {
            kind: FailureKind::Request(why),
            time_s: t0,
            state: y0.to_vec(),
            partial: Solution::with_capacity(y0.len(), 0),
        })
    }

    /// The same failure in plain numbers.
    pub(crate) fn real(self) -> Box<SolveError<f64>> {
        Box::new(SolveError {
            kind: self.kind,
            time_s: self.time_s,
            state: self.state.iter().map(|v| v.real()).collect(),
            partial: self.partial.real(),
        })
    }
}

impl FailureKind {
    /// The failure in words, for a solve that had reached time `t` (s).
    #[must_use]
    pub fn describe(&self, t: f64) -> String {
        match self {
            Self::Request(why) => format!("the solve cannot start: {why}"),
            Self::NonFinite { step_s } => format!(
                "a state became infinite or NaN in the step of {step_s:.3e} s that starts at \
                 t = {t:.6} s; take smaller steps or check model and input there"
            ),
            Self::StepTooSmall { step_s } => format!(
                "the error control asked for a step of {step_s:.3e} s at t = {t:.6} s; the problem \
                 is too stiff there, or the tolerance is below rounding"
            ),
            Self::TooManySteps { limit } => format!(
                "the limit of {limit} steps was reached at t = {t:.6} s; the problem is too stiff there: check \
                 the model and the units of the data, or loosen the tolerance"
            ),
            Self::Backward(kind) => {
                format!("in the backward solve of the adjoint, {}", kind.describe(t))
            }
        }
    }
}

impl<S> fmt::Display for SolveError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.kind.describe(self.time_s))
    }
}

// `unwrap` prints this: the message, not the trajectory.
impl<S> fmt::Debug for SolveError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SolveError")
            .field("kind", &self.kind)
            .field("time_s", &self.time_s)
            .finish_non_exhaustive()
    }
}

impl<S> std::error::Error for SolveError<S> {}
