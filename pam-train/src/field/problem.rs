//! Experiments to which a field is fitted.

use pam_core::ParametricField;
use pam_core::parallel;
use pam_solvers::controller::StepController;
use pam_solvers::sensitivity::Problem;
use pam_solvers::{Integrator, ParametricInput, SaveAt, Term};
use thiserror::Error;

/// One run of a system: what drove it, where it started, what was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment<I> {
    /// Name in messages.
    pub name: String,
    /// The input `u(t)`.
    pub input: I,
    /// The state at the first time.
    pub initial_state: Vec<f64>,
    /// Times of the measurements, increasing, s. The solve starts at the first.
    pub times_s: Vec<f64>,
    /// The measured outputs, row-major `[times, outputs]`.
    pub measured: Vec<f64>,
}

/// Which states are measured, and how well.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    /// Index of the state behind each output.
    pub states: Vec<usize>,
    /// Standard deviation of the noise of each output, in its unit.
    pub noise: Vec<f64>,
}

impl Outputs {
    /// Pairs of a state's index and the standard deviation of its noise.
    pub fn new(outputs: impl IntoIterator<Item = (usize, f64)>) -> Self {
        let (states, noise) = outputs.into_iter().unzip();
        Self { states, noise }
    }

    /// States whose noise is not known: its standard deviation is NaN. A diagnosis estimates it; a fit by least squares
    /// refuses it.
    pub fn of_unknown_noise(states: impl IntoIterator<Item = usize>) -> Self {
        Self::new(states.into_iter().map(|state| (state, f64::NAN)))
    }

    /// Number of outputs.
    #[must_use]
    pub fn len(&self) -> usize {
        self.states.len()
    }

    /// Whether nothing is measured.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.states.is_empty()
    }
}

/// A field that cannot be fitted.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FieldError {
    /// Numbers that do not belong together.
    #[error("{0}")]
    Shape(String),
    /// The field cannot be solved over an experiment.
    #[error("experiment `{experiment}`: {why}")]
    Solve {
        /// Name of the experiment.
        experiment: String,
        /// Why the solve stopped.
        why: String,
    },
}

/// A field, the experiments that it is to reproduce, and the method that solves it.
pub struct FieldProblem<'a, F, I> {
    /// The field with its present parameters.
    pub field: &'a F,
    /// The experiments.
    pub experiments: &'a [Experiment<I>],
    /// The measured states.
    pub outputs: Outputs,
    /// Method and step control.
    pub integrator: &'a Integrator<dyn StepController>,
}

impl<F, I> FieldProblem<'_, F, I>
where
    F: ParametricField + Sync,
    I: ParametricInput + Sync,
{
    /// Checks that outputs, experiments and field fit together.
    ///
    /// # Errors
    /// [`FieldError::Shape`] with the experiment and what does not fit.
    pub fn check(&self) -> Result<(), FieldError> {
        let states = self.field.state_len();
        let fail = |what: String| Err(FieldError::Shape(what));
        let o = &self.outputs;
        if o.is_empty() || o.noise.len() != o.len() || o.states.iter().any(|&s| s >= states) {
            return fail(format!(
                "outputs {:?} with {} noise levels do not fit a field of {states} states",
                o.states,
                o.noise.len()
            ));
        }
        if let Some(bad) = o.noise.iter().find(|n| !(n.is_finite() && **n > 0.0)) {
            return fail(format!("a noise level must be positive and finite, got {bad}"));
        }
        if self.experiments.is_empty() {
            return fail("there is no experiment to fit".into());
        }
        for e in self.experiments {
            let (rows, n) = (e.times_s.len(), e.initial_state.len());
            if n != states || rows < 2 || e.measured.len() != rows * o.len() {
                return fail(format!(
                    "experiment `{}`: {n} initial values for {states} states, {} measured values for \
                     {rows} times (at least 2) of {} outputs",
                    e.name,
                    e.measured.len(),
                    o.len()
                ));
            }
            if let Some(k) = (1..rows).find(|&k| {
                e.times_s[k].partial_cmp(&e.times_s[k - 1]) != Some(std::cmp::Ordering::Greater)
            }) {
                return fail(format!(
                    "experiment `{}`: times must increase, t[{k}] = {} s does not",
                    e.name, e.times_s[k]
                ));
            }
            if let Some(k) = e.measured.iter().position(|v| !v.is_finite()) {
                return fail(format!(
                    "experiment `{}`: the measurement at t = {} s is not finite; drop that row",
                    e.name,
                    e.times_s[k / o.len()]
                ));
            }
        }
        Ok(())
    }

    /// The states of every experiment at its times, row-major `[times, states]`, with other parameters.
    ///
    /// # Errors
    /// [`FieldError::Solve`] for the first experiment that cannot be solved.
    pub fn predict(&self, parameters: &[f64]) -> Result<Vec<Vec<f64>>, FieldError> {
        // Fields over plain numbers need not be shareable between threads: each solves its own.
        parallel::map(self.experiments.len(), |k| {
            let e = &self.experiments[k];
            let field = self.field.with_parameters::<f64>(parameters);
            let term = Term::new(&field, &e.input);
            let (t0, t1) = (e.times_s[0], e.times_s[e.times_s.len() - 1]);
            self.integrator
                .solve(&term, t0, t1, &e.initial_state, SaveAt::Times(&e.times_s))
                .map(|s| s.states().to_vec())
                .map_err(|error| failed(e, &error))
        })
        .into_iter()
        .collect()
    }

    /// The errors `predicted − measured` of one experiment, row-major `[times, outputs]`.
    #[must_use]
    pub fn errors(&self, experiment: usize, states: &[f64]) -> Vec<f64> {
        let n = self.field.state_len();
        let outputs = self.outputs.states.len();
        let measured = self.experiments[experiment].measured.chunks_exact(outputs);
        states
            .chunks_exact(n)
            .zip(measured)
            .flat_map(|(y, m)| self.outputs.states.iter().zip(m).map(move |(&s, m)| y[s] - m))
            .collect()
    }

    pub(super) fn of<'b, G>(&'b self, field: &'b G, experiment: usize) -> Problem<'b, G, I> {
        let e = &self.experiments[experiment];
        Problem {
            field,
            input: &e.input,
            t0: e.times_s[0],
            t1: e.times_s[e.times_s.len() - 1],
            y0: &e.initial_state,
            observations_s: &e.times_s,
            integrator: self.integrator,
        }
    }
}

pub(super) fn failed<I>(experiment: &Experiment<I>, error: &dyn std::fmt::Display) -> FieldError {
    FieldError::Solve { experiment: experiment.name.clone(), why: error.to_string() }
}
