//! Any loss of any field, made small by L-BFGS.

use super::problem::{Experiment, FieldError, FieldProblem, failed};
use crate::optimiser::{Lbfgs, LbfgsSettings, StepKind};
use pam_core::ParametricField;
use pam_core::parallel;
use pam_solvers::ParametricInput;
use pam_solvers::sensitivity::GradientMethod;

/// A loss of the states of one experiment. Closures
/// `|experiment, states, cotangents| -> value` are losses; `states` and `cotangents` are row-major
/// `[times, states]`, and `cotangents` holds zeros.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no loss of an experiment",
    note = "use `outputs_error(states, outputs)`, or write a closure with all types: \
            `|experiment: &Experiment<I>, states: &[f64], cotangents: &mut [f64]| -> f64`"
)]
pub trait FieldLoss<I>: Sync {
    /// Returns the loss of `states` and writes its derivative by every state to `cotangents`.
    fn value_and_cotangents(
        &self,
        experiment: &Experiment<I>,
        states: &[f64],
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
        states: &[f64],
        cotangents: &mut [f64],
    ) -> f64 {
        self(experiment, states, cotangents)
    }
}

/// The mean over rows and outputs of `((predicted − measured) / noise)²`, for a field of `state_len` states.
pub fn outputs_error<I>(
    state_len: usize,
    outputs: super::Outputs,
) -> impl Fn(&Experiment<I>, &[f64], &mut [f64]) -> f64 {
    move |experiment, states, cotangents| {
        let m = outputs.len();
        let scale = 1.0 / experiment.measured.len() as f64;
        let rows = states.chunks_exact(state_len).zip(cotangents.chunks_exact_mut(state_len));
        let mut value = 0.0;
        for ((y, w), measured) in rows.zip(experiment.measured.chunks_exact(m)) {
            for ((&state, &noise), &target) in
                outputs.states.iter().zip(&outputs.noise).zip(measured)
            {
                let error = (y[state] - target) / noise;
                value += scale * error * error;
                w[state] += 2.0 * scale * error / noise;
            }
        }
        value
    }
}

/// Settings of [`FieldProblem::train`].
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
        let parts: Result<Vec<_>, FieldError> = parallel::map(self.experiments.len(), |k| {
            let experiment = &self.experiments[k];
            let field = self.field.with_parameters::<f64>(parameters);
            let mut of_states = |_times: &[f64], states: &[f64], cotangents: &mut [f64]| {
                loss.value_and_cotangents(experiment, states, cotangents)
            };
            method
                .value_and_gradient(&self.of(&field, k), &mut of_states)
                .map(|g| (g.value, g.parameters))
                .map_err(|error| failed(experiment, &error))
        })
        .into_iter()
        .collect();
        let share = 1.0 / self.experiments.len().max(1) as f64;
        let mut sum = (0.0, vec![0.0; parameters.len()]);
        for (value, gradient) in parts? {
            sum.0 += share * value;
            sum.1.iter_mut().zip(gradient).for_each(|(s, g)| *s += share * g);
        }
        Ok(sum)
    }

    /// Makes a loss small by L-BFGS from the field's present parameters. `progress` is told step and loss and
    /// returns whether to go on.
    ///
    /// # Errors
    /// [`FieldError`] if shapes do not fit, or the field cannot be solved where it starts.
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
        Ok(TrainedField { parameters: unscaled(&at), losses })
    }
}
