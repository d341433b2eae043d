//! A field with small forces of every simple kind, for the flexible model.
//!
//! What a field misses acts on its derivatives, and comes out of its outputs through its dynamics: a missing force
//! makes a position drift. Functions of the present state do not look like that. The responses of the outputs to terms
//! `w φ(y, u)` in the derivatives do, to first order in `w`.

use pam_core::{DryFriction, FieldNames, ParametricField, Scalar, VectorField};
use pam_numerics::statistics::root_mean_square;
use std::sync::Arc;

/// Largest number of states from which on a derivative is perturbed by functions of its own state alone.
const MANY_STATES: usize = 4;

/// Sizes by which the arguments of the perturbations are divided.
#[derive(Debug, Clone)]
pub(super) struct Sizes {
    states: Vec<f64>,
    /// Size of a state at which its direction turns, relative to its size.
    direction_width: f64,
}

impl Sizes {
    /// Sizes of states in a motion, given state by state.
    pub(super) fn of(states: &[Vec<f64>], direction_width: f64) -> Self {
        let size = |y: &Vec<f64>| root_mean_square(y).max(1e-12);
        Self { states: states.iter().map(size).collect(), direction_width }
    }

    /// Number of terms in each derivative of a field of so many inputs.
    fn terms(&self, inputs: usize) -> usize {
        let states = self.states.len();
        1 + inputs + 4 * if states < MANY_STATES { states } else { 1 }
    }

    /// Calls `visit(state, k, φ_k(y, u))` for the terms of every derivative.
    fn each_term(&self, y: &[f64], u: &[f64], mut visit: impl FnMut(usize, usize, f64)) {
        let n = self.states.len();
        for state in 0..n {
            let arguments = if n < MANY_STATES { 0..n } else { state..state + 1 };
            let mut k = 0;
            let mut term = |value: f64| {
                visit(state, k, value);
                k += 1;
            };
            term(1.0);
            u.iter().for_each(|&u| term(u));
            for i in arguments {
                let v = y[i] / self.states[i];
                term(v);
                term((v / self.direction_width).tanh());
                term(v * v.abs());
                term(v * v * v);
            }
        }
    }
}

/// A field with the weights of all terms as further parameters, which are zero.
pub(super) struct Perturbed<'a, F> {
    field: &'a F,
    sizes: Arc<Sizes>,
}

impl<'a, F: ParametricField> Perturbed<'a, F> {
    pub(super) fn new(field: &'a F, sizes: Arc<Sizes>) -> Self {
        Self { field, sizes }
    }

    /// Number of weights.
    pub(super) fn weight_len(&self) -> usize {
        self.field.state_len() * self.sizes.terms(self.field.input_len())
    }
}

/// The field over a scalar, with its weights.
pub(super) struct Weighted<V, S> {
    field: V,
    weights: Vec<S>,
    sizes: Arc<Sizes>,
}

impl<S: Scalar, V: VectorField<S>> VectorField<S> for Weighted<V, S> {
    fn state_len(&self) -> usize {
        self.field.state_len()
    }
    fn input_len(&self) -> usize {
        self.field.input_len()
    }
    fn work_len(&self) -> usize {
        self.field.work_len()
    }
    fn eval_into(&self, t: f64, y: &[S], u: &[S], dy: &mut [S], work: &mut [S]) {
        self.field.eval_into(t, y, u, dy, work);
        let real = |values: &[S]| values.iter().map(|v| v.real()).collect::<Vec<f64>>();
        let terms = self.sizes.terms(u.len());
        // The weights are zero, so that only the value of a term matters.
        self.sizes.each_term(&real(y), &real(u), |state, k, value| {
            dy[state] += self.weights[state * terms + k].scaled(value);
        });
    }
    fn output_len(&self) -> usize {
        self.field.output_len()
    }
    fn outputs_into(&self, t: f64, y: &[S], u: &[S], out: &mut [S]) {
        self.field.outputs_into(t, y, u, out);
    }
}

impl<F: ParametricField> VectorField<f64> for Perturbed<'_, F> {
    fn state_len(&self) -> usize {
        self.field.state_len()
    }
    fn input_len(&self) -> usize {
        self.field.input_len()
    }
    fn work_len(&self) -> usize {
        self.field.work_len()
    }
    fn eval_into(&self, t: f64, y: &[f64], u: &[f64], dy: &mut [f64], work: &mut [f64]) {
        self.field.eval_into(t, y, u, dy, work);
    }
    fn output_len(&self) -> usize {
        self.field.output_len()
    }
    fn outputs_into(&self, t: f64, y: &[f64], u: &[f64], out: &mut [f64]) {
        self.field.outputs_into(t, y, u, out);
    }
}

impl<F: ParametricField> ParametricField for Perturbed<'_, F> {
    type With<S: Scalar> = Weighted<F::With<S>, S>;

    fn parameters(&self) -> Vec<f64> {
        let mut all = self.field.parameters();
        all.resize(all.len() + self.weight_len(), 0.0);
        all
    }

    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Self::With<S> {
        let (own, weights) = parameters.split_at(parameters.len() - self.weight_len());
        Weighted {
            field: self.field.with_parameters(own),
            weights: weights.to_vec(),
            sizes: Arc::clone(&self.sizes),
        }
    }

    fn names(&self) -> FieldNames {
        self.field.names()
    }

    fn dry_friction(&self) -> Option<DryFriction> {
        self.field.dry_friction()
    }
}
