//! A loss of signals as a loss of states.

use super::experiment::Experiment;
use pam_autodiff::{Tape, Var};
use pam_core::{ParametricField, Scalar, VectorField};
use pam_solvers::{Input, Side};

/// Outputs of a field beside its states, and their pullback by the tape: a gradient method sees states, a loss all
/// signals.
pub(super) struct SignalLoss<'a, F, I> {
    field: &'a F,
    parameters: &'a [f64],
    experiment: &'a Experiment<I>,
    /// The derivative of the last loss by the parameters through the outputs alone.
    pub(super) by_parameters: Vec<f64>,
}

impl<'a, F: ParametricField, I: Input<f64>> SignalLoss<'a, F, I> {
    pub(super) fn new(field: &'a F, parameters: &'a [f64], experiment: &'a Experiment<I>) -> Self {
        Self { field, parameters, experiment, by_parameters: vec![0.0; parameters.len()] }
    }

    /// The loss of the states, and its derivative by them in `cotangents`.
    pub(super) fn of_states(
        &mut self,
        states: &[f64],
        cotangents: &mut [f64],
        loss: impl FnOnce(&[f64], &mut [f64]) -> f64,
    ) -> f64 {
        let (n, h) = (self.field.state_len(), self.field.output_len());
        if h == 0 {
            return loss(states, cotangents);
        }
        let times = &self.experiment.times_s;
        let inputs: Vec<Vec<f64>> = times
            .iter()
            .map(|&t| {
                let mut u = vec![0.0; self.experiment.input.input_len()];
                self.experiment.input.value_into(t, Side::Right, &mut u);
                u
            })
            .collect();
        let field = self.field.with_parameters::<f64>(self.parameters);
        let mut signals = vec![0.0; times.len() * (n + h)];
        for (k, row) in signals.chunks_exact_mut(n + h).enumerate() {
            row[..n].copy_from_slice(&states[k * n..(k + 1) * n]);
            let (y, out) = row.split_at_mut(n);
            field.outputs_into(times[k], y, &inputs[k], out);
        }
        let mut by_signals = vec![0.0; signals.len()];
        let value = loss(&signals, &mut by_signals);
        let mut tape = Tape::<f64>::new();
        let parameters = tape.variables(self.parameters);
        let field = tape.record(|| self.field.with_parameters::<Var>(&parameters));
        let mark = tape.mark();
        let mut gathered = pam_autodiff::Gathered::default();
        for (k, row) in by_signals.chunks_exact(n + h).enumerate() {
            tape.rewind(mark);
            let y = tape.variables(&states[k * n..(k + 1) * n]);
            let u: Vec<Var> = inputs[k].iter().map(|&v| Var::constant(v)).collect();
            let mut out = vec![Var::constant(0.0); h];
            tape.record(|| field.outputs_into(times[k], &y, &u, &mut out));
            let seeds = out.iter().copied().zip(row[n..].iter().copied());
            let derivatives = tape.reverse_since(mark, &mut gathered, seeds);
            for ((w, y), direct) in cotangents[k * n..(k + 1) * n].iter_mut().zip(&y).zip(row) {
                *w += direct + derivatives.of(*y);
            }
        }
        tape.rewind(mark);
        let derivatives = tape.reverse_gathered(&gathered, []);
        self.by_parameters = parameters.iter().map(|p| derivatives.of(*p)).collect();
        value
    }
}
