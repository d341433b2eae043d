//! Results of the study.

use super::method::Kind;
use serde::{Deserialize, Serialize};

/// One method on one problem with one solver.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Part of the study that the row belongs to.
    pub part: String,
    /// The problem.
    pub problem: String,
    /// Activation of its network.
    pub activation: Option<String>,
    /// Width of its network.
    pub width: Option<usize>,
    /// Number of parameters.
    pub parameters: usize,
    /// Number of trajectories.
    pub trajectories: usize,
    /// Length of the solve, s.
    pub horizon_s: f64,
    /// The method.
    pub method: String,
    /// How the field is differentiated.
    pub differentiation: String,
    /// The gradient that the method is expected to return.
    pub kind: Kind,
    /// The Runge–Kutta method.
    pub solver: String,
    /// Relative tolerance.
    pub rtol: Option<f64>,
    /// Absolute tolerance.
    pub atol: Option<f64>,
    /// Size of constant steps, s.
    pub step_s: Option<f64>,
    /// The loss.
    pub value: Option<f64>,
    /// Its relative error against the truth at a tight tolerance.
    pub value_error: Option<f64>,
    /// Largest error of the first state over the observations, against the same truth.
    pub state_error: Option<f64>,
    /// Relative error of the gradient against that of the frozen steps, by dual numbers through the
    /// solver; with many parameters on a sample of them. The largest over the groups of numbers.
    pub replay_error: Option<f64>,
    /// Relative error of the gradient against the truth at a tight tolerance, or in closed form. The
    /// largest over the groups of numbers.
    pub gradient_error: Option<f64>,
    /// Median time for value and gradient, s.
    pub seconds: Option<f64>,
    /// Largest number of bytes allocated at a time; absent if the program does not count them.
    pub peak_bytes: Option<usize>,
    /// Bytes that the method says it stored.
    pub checkpoint_bytes: usize,
    /// Evaluations of the field.
    pub evaluations: usize,
    /// Products of a cotangent with the field's Jacobians.
    pub vjps: usize,
    /// Products of the field's Jacobians with a tangent.
    pub jvps: usize,
    /// Accepted steps of the forward solve.
    pub steps: usize,
    /// Rejected steps of the forward solve.
    pub rejected: usize,
    /// Steps taken again.
    pub replayed: usize,
    /// Accepted steps of backward solves.
    pub backward_steps: usize,
    /// Rejected steps of backward solves.
    pub backward_rejected: usize,
    /// Why there is no gradient.
    pub failure: Option<String>,
}

impl Row {
    /// Tolerance or step in words.
    #[must_use]
    pub fn steps_text(&self) -> String {
        match (self.rtol, self.step_s) {
            (Some(rtol), _) => format!("{rtol:.0e}"),
            (None, Some(step_s)) => format!("{} ms", (step_s * 1e6).round() / 1e3),
            (None, None) => "–".into(),
        }
    }

    /// Method and differentiation in words.
    #[must_use]
    pub fn method_text(&self) -> String {
        match self.differentiation.as_str() {
            "hand" | "tape" | "dual" => format!("{} / {}", self.method, self.differentiation),
            _ => self.method.clone(),
        }
    }

    /// Problem, activation and width in words.
    #[must_use]
    pub fn problem_text(&self) -> String {
        let mut text = self.problem.clone();
        if let Some(activation) = &self.activation {
            text += &format!(", {activation}");
        }
        if let Some(width) = self.width {
            text += &format!(", width {width}");
        }
        text
    }

    /// Measured memory, or what the method says it stored.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        self.peak_bytes.unwrap_or(self.checkpoint_bytes)
    }

    /// The row without what differs from run to run: time and measured memory.
    #[must_use]
    pub fn repeatable(&self) -> Self {
        Self { seconds: None, peak_bytes: None, ..self.clone() }
    }
}

/// All that the study found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StudyResult {
    /// Whether it was the short form.
    pub quick: bool,
    /// Most repeats of a timing.
    pub repeat: usize,
    /// The processor, where it is known; everything runs on one thread of it.
    pub processor: Option<String>,
    /// The rows, in the order of the study.
    pub rows: Vec<Row>,
}

impl StudyResult {
    /// The rows of one part.
    pub fn part<'a>(&'a self, part: &'a str) -> impl Iterator<Item = &'a Row> + Clone {
        self.rows.iter().filter(move |row| row.part == part)
    }
}
