//! Experiments to which a field is fitted.

use super::experiment::Experiment;
use super::outputs::Outputs;
use super::simulate::Numbers;
use pam_core::ParametricField;
use pam_core::parallel;
use pam_numerics::statistics::root_mean_square;
use pam_solvers::controller::StepController;
use pam_solvers::{Input, Integrator};
use std::path::PathBuf;
use thiserror::Error;

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
    /// A file of an experiment cannot be read.
    #[error("{}: {why}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why, with line and column.
        why: String,
    },
}

/// A field, the experiments that it is to reproduce, and the method that solves it.
///
/// ```
/// use pam_core::field_fn;
/// use pam_solvers::{InputFn, Integrator, PidController, SaveAt, Tableau, Term};
/// use pam_train::field::{Experiment, FieldProblem, LeastSquares, Outputs};
///
/// // A motor, τ ω̇ = k u − ω: parameters τ = 0.2 s and k = 3 rad/s per volt, of which the guess is wrong.
/// let guess = field_fn!([0.3, 2.0], 1 => 1, |_t, y, u, p, dy| dy[0] = (p[1] * u[0] - y[0]) / p[0]);
/// let real = field_fn!([0.2, 3.0], 1 => 1, |_t, y, u, p, dy| dy[0] = (p[1] * u[0] - y[0]) / p[0]);
/// let voltage = InputFn::new(1, |t: f64, u: &mut [f64]| u[0] = (4.0 * t).sin());
///
/// // The measured speed; here it is simulated.
/// let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-8, 1e-8));
/// let times_s: Vec<f64> = (0..200).map(|k| 0.02 * f64::from(k)).collect();
/// let run = integrator.solve(
///     &Term::new(&real, voltage), 0.0, times_s[199], &[0.0], SaveAt::Times(&times_s),
/// )?;
/// let measured = [Experiment::new("sine", voltage, times_s, run.component(0).collect())];
///
/// let outputs = Outputs::new([(0, 0.01)]); // state 0, noise of 0.01 rad/s
/// let problem = FieldProblem::new(&guess, &measured, outputs, &integrator);
/// let fit = problem.least_squares(&LeastSquares::default())?;
/// assert!((fit.parameters[0] - 0.2).abs() < 1e-5 && (fit.parameters[1] - 3.0).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct FieldProblem<'a, F, I> {
    /// The field with its present parameters.
    pub field: &'a F,
    /// The experiments to which it is fitted.
    pub experiments: &'a [Experiment<I>],
    /// Experiments that no fit sees; errors are reported on them.
    pub held_out: &'a [Experiment<I>],
    /// The measured signals.
    pub outputs: Outputs,
    /// Method and step control.
    pub integrator: &'a Integrator<dyn StepController>,
}

impl<F, I> Clone for FieldProblem<'_, F, I> {
    fn clone(&self) -> Self {
        Self { outputs: self.outputs.clone(), ..*self }
    }
}

impl<'a, F, I> FieldProblem<'a, F, I> {
    /// A field, experiments with it, what was measured of it, and what solves it; no experiment is held out.
    pub fn new(
        field: &'a F,
        experiments: &'a [Experiment<I>],
        outputs: Outputs,
        integrator: &'a Integrator<dyn StepController>,
    ) -> Self {
        Self { field, experiments, held_out: &[], outputs, integrator }
    }

    /// The same with experiments that no fit sees.
    #[must_use]
    pub fn with_held_out(self, held_out: &'a [Experiment<I>]) -> Self {
        Self { held_out, ..self }
    }
}

/// The error on an experiment that was not fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOutError {
    /// Name of the experiment.
    pub experiment: String,
    /// Root mean square error of each output, in its unit.
    pub rms: Vec<f64>,
}

impl<F, I> FieldProblem<'_, F, I>
where
    F: ParametricField + Sync,
    I: Input<f64> + Sync,
{
    /// Names of the outputs.
    #[must_use]
    pub fn output_names(&self) -> Vec<String> {
        let (names, states) = (self.field.names(), self.field.state_len());
        self.outputs.signals.iter().map(|&s| names.signal(s, states)).collect()
    }

    /// Checks that outputs, experiments and field fit together.
    ///
    /// # Errors
    /// [`FieldError::Shape`] with the experiment and what does not fit.
    pub fn check(&self) -> Result<(), FieldError> {
        let states = self.field.state_len();
        let signals = states + self.field.output_len();
        let fail = |what: String| Err(FieldError::Shape(what));
        let o = &self.outputs;
        if o.is_empty() || o.noise.len() != o.len() || o.signals.iter().any(|&s| s >= signals) {
            return fail(format!(
                "outputs {:?} with {} noise levels do not fit a field of {states} states and {} outputs",
                o.signals,
                o.noise.len(),
                signals - states
            ));
        }
        if let Some(bad) = o.noise.iter().find(|n| n.is_infinite() || **n <= 0.0) {
            return fail(format!(
                "a noise level must be positive, or NaN if it is not known, got {bad}"
            ));
        }
        if self.experiments.is_empty() {
            return fail("there is no experiment to fit".into());
        }
        let (names, outputs) = (self.field.names(), self.output_names());
        let named = |k: usize| o.signals[k] >= states || o.signals[k] < names.states.len();
        let outputs = if (0..o.len()).all(named) { outputs } else { Vec::new() };
        for e in self.experiments.iter().chain(self.held_out) {
            let (rows, n) = (e.times_s.len(), e.initial_state.len());
            if (n != states && n != 0) || rows < 2 || e.measured.len() != rows * o.len() {
                return fail(format!(
                    "experiment `{}`: {n} initial values for {states} states, {} measured values for \
                     {rows} times (at least 2) of {} outputs",
                    e.name,
                    e.measured.len(),
                    o.len()
                ));
            }
            if let Some(why) = e.misnamed(&names, &outputs) {
                return fail(why);
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

    /// The state of an experiment at its first time: as given, or at rest, with measured states at their first
    /// measured value and all others at zero.
    #[must_use]
    pub fn initial_state(&self, experiment: &Experiment<I>) -> Vec<f64> {
        if !experiment.initial_state.is_empty() {
            return experiment.initial_state.clone();
        }
        let mut y0 = vec![0.0; self.field.state_len()];
        for (&signal, &measured) in self.outputs.signals.iter().zip(&experiment.measured) {
            if let Some(y) = y0.get_mut(signal) {
                *y = measured;
            }
        }
        y0
    }

    /// The signals (states, then outputs) of every experiment at its times, row-major `[times, signals]`, with other
    /// parameters.
    ///
    /// # Errors
    /// [`FieldError::Solve`] for the first experiment that cannot be solved.
    pub fn predict(&self, parameters: &[f64]) -> Result<Vec<Vec<f64>>, FieldError> {
        // Fields over plain numbers need not be shareable between threads: each solves its own.
        parallel::map(self.experiments.len(), |k| {
            let e = &self.experiments[k];
            let parameters = parameters.to_vec();
            self.simulate(e, &Numbers { parameters, ..self.numbers(e) })
        })
        .into_iter()
        .collect()
    }

    /// The errors `predicted − measured` of one experiment, row-major `[times, outputs]`, from its signals.
    #[must_use]
    pub fn errors(&self, experiment: &Experiment<I>, signals: &[f64]) -> Vec<f64> {
        let outputs = &self.outputs.signals;
        let measured = experiment.measured.chunks_exact(outputs.len());
        signals
            .chunks_exact(self.signal_len())
            .zip(measured)
            .flat_map(|(y, m)| outputs.iter().zip(m).map(move |(&s, m)| y[s] - m))
            .collect()
    }

    /// The errors on the held-out experiments, from their given starts, with other parameters and a delay of the input
    /// (s).
    ///
    /// # Errors
    /// [`FieldError::Solve`] for the first experiment that cannot be solved.
    pub fn held_out_errors(
        &self,
        parameters: &[f64],
        delay_s: f64,
    ) -> Result<Vec<HeldOutError>, FieldError> {
        let outputs = self.outputs.len();
        parallel::map(self.held_out.len(), |k| {
            let e = &self.held_out[k];
            let parameters = parameters.to_vec();
            let signals = self.simulate(e, &Numbers { parameters, delay_s, ..self.numbers(e) })?;
            let errors = self.errors(e, &signals);
            let of_output = |c: usize| -> f64 {
                let own: Vec<f64> = errors.iter().skip(c).step_by(outputs).copied().collect();
                root_mean_square(&own)
            };
            let rms = (0..outputs).map(of_output).collect();
            Ok(HeldOutError { experiment: e.name.clone(), rms })
        })
        .into_iter()
        .collect()
    }
}

pub(super) fn failed<I>(experiment: &Experiment<I>, error: &dyn std::fmt::Display) -> FieldError {
    FieldError::Solve { experiment: experiment.name.clone(), why: error.to_string() }
}
