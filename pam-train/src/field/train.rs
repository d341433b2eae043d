//! Any loss of any field, made small by L-BFGS.

use super::experiment::Experiment;
use super::outputs::Outputs;
use super::problem::{FieldError, FieldProblem, failed};
use super::signals::SignalLoss;
use crate::optimiser::{Lbfgs, LbfgsSettings, StepKind};
use pam_core::ParametricField;
use pam_core::parallel;
use pam_solvers::ParametricInput;
use pam_solvers::sensitivity::{GradientMethod, Problem};

/// A loss of the signals of one experiment: of its states, and after them of the outputs of the field. Closures
/// `|experiment, signals, cotangents| -> value` are losses; `signals` and `cotangents` are row-major
/// `[times, signals]`, and `cotangents` holds zeros.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no loss of an experiment",
    note = "use `outputs_error(problem.signal_len(), outputs)`, or write a closure with all types: \
            `|experiment: &Experiment<I>, signals: &[f64], cotangents: &mut [f64]| -> f64`"
)]
pub trait FieldLoss<I>: Sync {
    /// Returns the loss of `signals` and writes its derivative by every signal to `cotangents`.
    fn value_and_cotangents(
        &self,
        experiment: &Experiment<I>,
        signals: &[f64],
        cotangents: &mut [f64],
    ) -> f64;
}

impl<I, L> FieldLoss<I> for L
where
    L: Fn(&Experiment<I>, &[f64], &mut [f64]) -> f64 + Sync,
{
    fn value_and_cotangents(
        &self,
        experiment: &Experiment<I>,
        signals: &[f64],
        cotangents: &mut [f64],
    ) -> f64 {
        self(experiment, signals, cotangents)
    }
}

/// The mean over rows and outputs of `((predicted − measured) / noise)²`, for a field of `signal_len` signals (states
/// and outputs). An output of unknown noise counts in its own unit.
pub fn outputs_error<I>(
    signal_len: usize,
    outputs: Outputs,
) -> impl Fn(&Experiment<I>, &[f64], &mut [f64]) -> f64 {
    let units = outputs.units();
    move |experiment, signals, cotangents| {
        let m = outputs.len();
        let scale = 1.0 / experiment.measured.len() as f64;
        let rows = signals.chunks_exact(signal_len).zip(cotangents.chunks_exact_mut(signal_len));
        let mut value = 0.0;
        for ((y, w), measured) in rows.zip(experiment.measured.chunks_exact(m)) {
            for ((&signal, &unit), &target) in outputs.signals.iter().zip(&units).zip(measured) {
                let error = (y[signal] - target) / unit;
                value += scale * error * error;
                w[signal] += 2.0 * scale * error / unit;
            }
        }
        value
    }
}

/// Settings of [`FieldProblem::train`].
///
/// ```
/// use pam_core::{ParametricField, Scalar, VectorField};
/// use pam_autodiff::ByTape;
/// use pam_solvers::sensitivity::DiscreteAdjoint;
/// use pam_solvers::{Integrator, NoInput, PidController, Tableau};
/// use pam_train::field::{Experiment, FieldProblem, FieldTraining, Outputs, outputs_error};
///
/// /// `ẏ = −rate · y`
/// struct Decay<S>(S);
///
/// impl<S: Scalar> VectorField<S> for Decay<S> {
///     fn state_len(&self) -> usize {
///         1
///     }
///     fn input_len(&self) -> usize {
///         0
///     }
///     fn eval_into(&self, _t: f64, y: &[S], _u: &[S], dy: &mut [S], _work: &mut [S]) {
///         dy[0] = -(self.0 * y[0]);
///     }
/// }
///
/// impl ParametricField for Decay<f64> {
///     type With<S: Scalar> = Decay<S>;
///     fn parameters(&self) -> Vec<f64> {
///         vec![self.0]
///     }
///     fn with_parameters<S: Scalar>(&self, p: &[S]) -> Decay<S> {
///         Decay(p[0])
///     }
/// }
///
/// let times_s: Vec<f64> = (0..50).map(|k| 0.02 * f64::from(k)).collect();
/// let measured = times_s.iter().map(|t| (-3.0 * t).exp()).collect();
/// let experiments = [Experiment::new("a", NoInput, times_s, measured).starting_at(vec![1.0])];
/// let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-8, 1e-8));
/// let guess = Decay(1.0);
/// let outputs = Outputs::new([(0, 1e-3)]); // state 0, noise of 0.001
/// let problem = FieldProblem::new(&guess, &experiments, outputs.clone(), &integrator);
/// let method = DiscreteAdjoint::new(ByTape);
/// let loss = outputs_error(1, outputs);
/// let settings = FieldTraining::default();
/// let trained = problem.train(&loss, &method, &settings, |_step, _loss| true)?;
/// assert!((trained.parameters[0] - 3.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldTraining {
    /// L-BFGS.
    pub lbfgs: LbfgsSettings,
    /// Steps at most.
    pub iterations: usize,
    /// Smallest scale of a parameter: the optimiser moves `parameter / max(|start|, floor)`.
    pub scale_floor: f64,
    /// Ends when a step lowers the loss by less than this share.
    pub least_gain: f64,
}

impl Default for FieldTraining {
    fn default() -> Self {
        Self {
            lbfgs: LbfgsSettings::default(),
            iterations: 200,
            scale_floor: 0.1,
            least_gain: 1e-7,
        }
    }
}

/// A trained field.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainedField {
    /// Its parameters.
    pub parameters: Vec<f64>,
    /// The loss before each step, and at the end.
    pub losses: Vec<f64>,
    /// The mean loss on the held-out experiments with the first and with the trained parameters; absent without such
    /// experiments.
    pub held_out: Option<[f64; 2]>,
}

impl<F, I> FieldProblem<'_, F, I>
where
    F: ParametricField + Sync,
    F::With<f64>: ParametricField,
    I: ParametricInput + Sync,
{
    /// The mean of a loss over the experiments, and its gradient with respect to the parameters of the field.
    /// Experiments are solved on all cores; the sums do not depend on their number.
    ///
    /// # Errors
    /// [`FieldError`] if an experiment cannot be solved.
    pub fn value_and_gradient<M>(
        &self,
        parameters: &[f64],
        loss: &dyn FieldLoss<I>,
        method: &M,
    ) -> Result<(f64, Vec<f64>), FieldError>
    where
        M: GradientMethod<F::With<f64>, I> + Sync,
    {
        self.loss_over(self.experiments, parameters, loss, method)
    }

    /// The mean of a loss over some experiments, and its gradient.
    fn loss_over<M>(
        &self,
        experiments: &[Experiment<I>],
        parameters: &[f64],
        loss: &dyn FieldLoss<I>,
        method: &M,
    ) -> Result<(f64, Vec<f64>), FieldError>
    where
        M: GradientMethod<F::With<f64>, I> + Sync,
    {
        let parts: Result<Vec<_>, FieldError> = parallel::map(experiments.len(), |k| {
            let experiment = &experiments[k];
            let field = self.field.with_parameters::<f64>(parameters);
            let y0 = self.initial_state(experiment);
            let problem = Problem {
                field: &field,
                input: &experiment.input,
                t0: experiment.times_s[0],
                t1: experiment.times_s[experiment.times_s.len() - 1],
                y0: &y0,
                observations_s: &experiment.times_s,
                integrator: self.integrator,
            };
            let mut of_signals = SignalLoss::new(self.field, parameters, experiment);
            let mut of_states = |_times: &[f64], states: &[f64], cotangents: &mut [f64]| {
                of_signals.of_states(states, cotangents, |signals, cotangents| {
                    loss.value_and_cotangents(experiment, signals, cotangents)
                })
            };
            let found = method
                .value_and_gradient(&problem, &mut of_states)
                .map_err(|error| failed(experiment, &error))?;
            let mut gradient = found.parameters;
            gradient.iter_mut().zip(&of_signals.by_parameters).for_each(|(g, own)| *g += own);
            Ok((found.value, gradient))
        })
        .into_iter()
        .collect();
        let share = 1.0 / experiments.len().max(1) as f64;
        let mut sum = (0.0, vec![0.0; parameters.len()]);
        for (value, gradient) in parts? {
            sum.0 += share * value;
            sum.1.iter_mut().zip(gradient).for_each(|(s, g)| *s += share * g);
        }
        Ok(sum)
    }

    /// [`train`](Self::train) by the error of the outputs ([`outputs_error`]) with the usual settings and no report of
    /// progress.
    ///
    /// # Errors
    /// As [`train`](Self::train).
    pub fn train_outputs<M>(&self, method: &M) -> Result<TrainedField, FieldError>
    where
        M: GradientMethod<F::With<f64>, I> + Sync,
    {
        let loss = outputs_error(self.signal_len(), self.outputs.clone());
        self.train(&loss, method, &FieldTraining::default(), |_step, _loss| true)
    }

    /// Makes a loss small by L-BFGS from the field's present parameters. `progress` is told step and loss and
    /// returns whether to go on. Held-out experiments take no part; the loss on them is reported.
    ///
    /// # Errors
    /// [`FieldError`] if shapes do not fit, the field sticks (no gradient method cuts steps at its switches; use
    /// [`least_squares`](Self::least_squares)), or it cannot be solved where it starts.
    pub fn train<M>(
        &self,
        loss: &dyn FieldLoss<I>,
        method: &M,
        settings: &FieldTraining,
        mut progress: impl FnMut(usize, f64) -> bool,
    ) -> Result<TrainedField, FieldError>
    where
        M: GradientMethod<F::With<f64>, I> + Sync,
    {
        self.check()?;
        if self.field.dry_friction().is_some() {
            return Err(FieldError::Shape(
                "a field with dry friction is not trained by gradient methods; fit it by least squares".into(),
            ));
        }
        let start = self.field.parameters();
        let scales: Vec<f64> = start.iter().map(|p| p.abs().max(settings.scale_floor)).collect();
        let unscaled =
            |at: &[f64]| -> Vec<f64> { at.iter().zip(&scales).map(|(a, s)| a * s).collect() };
        let (first, _) = self.value_and_gradient(&start, loss, method)?;
        let mut at: Vec<f64> = start.iter().zip(&scales).map(|(p, s)| p / s).collect();
        let mut optimiser = Lbfgs::new(settings.lbfgs, at.len());
        let mut losses = vec![first];
        for step in 0..settings.iterations {
            let last = losses[losses.len() - 1];
            if !progress(step, last) {
                break;
            }
            let outcome = optimiser.minimise_step(&mut at, &mut |at| {
                let (value, gradient) =
                    self.value_and_gradient(&unscaled(at), loss, method).ok()?;
                Some((value, gradient.iter().zip(&scales).map(|(g, s)| g * s).collect()))
            });
            if outcome.kind != StepKind::Moved {
                break;
            }
            losses.push(outcome.value);
            if last - outcome.value < settings.least_gain * last.abs() {
                break;
            }
        }
        let parameters = unscaled(&at);
        let on_held_out = |p: &[f64]| self.loss_over(self.held_out, p, loss, method).map(|l| l.0);
        let held_out = if self.held_out.is_empty() {
            None
        } else {
            Some([on_held_out(&start)?, on_held_out(&parameters)?])
        };
        Ok(TrainedField { parameters, losses, held_out })
    }
}
