//! Small fields without a network: those of the list and those of a file.

use super::{linear, quartic, stiff, van_der_pol};
use pam_core::{ParametricField, Scalar, VectorField};
use pam_expression::{Inputs, Program};
use std::sync::Arc;

/// The right-hand side of a small field.
#[derive(Debug, Clone)]
pub enum Rates {
    /// The damped oscillation.
    Linear,
    /// Van der Pol's oscillator.
    VanDerPol,
    /// `u̇ = (t − θ)⁴`.
    Quartic,
    /// A slow state with a fast one.
    Stiff,
    /// One expression of states, time and parameters for each state; states and parameters are in alphabetical order.
    Expressions(Arc<Program>),
}

/// `ẏ = f(t, y, p)` without input. The small problems share this type, for which each gradient method is compiled once.
#[derive(Debug, Clone)]
pub struct SmallField<S> {
    rates: Rates,
    states: usize,
    parameters: Vec<S>,
}

impl<S> SmallField<S> {
    /// The field with its number of states and its parameters.
    #[must_use]
    pub fn new(rates: Rates, states: usize, parameters: Vec<S>) -> Self {
        Self { rates, states, parameters }
    }
}

/// States, time and parameters, as expressions see them.
struct At<'a, S> {
    t: f64,
    y: &'a [S],
    p: &'a [S],
}

impl<S: Scalar> Inputs<S> for At<'_, S> {
    #[inline]
    fn input(&self, index: usize) -> S {
        match index.checked_sub(self.y.len()) {
            None => self.y[index],
            Some(0) => S::constant(self.t),
            Some(k) => self.p[k - 1],
        }
    }
}

impl<S: Scalar> VectorField<S> for SmallField<S> {
    fn state_len(&self) -> usize {
        self.states
    }
    fn input_len(&self) -> usize {
        0
    }
    fn eval_into(&self, t: f64, y: &[S], _u: &[S], dy: &mut [S], _work: &mut [S]) {
        let p = &self.parameters;
        match &self.rates {
            Rates::Linear => linear::rates(y, p, dy),
            Rates::VanDerPol => van_der_pol::rates(y, p, dy),
            Rates::Quartic => quartic::rates(t, p, dy),
            Rates::Stiff => stiff::rates(y, p, dy),
            Rates::Expressions(program) => program.values(&At { t, y, p }, dy),
        }
    }
}

impl ParametricField for SmallField<f64> {
    type With<S: Scalar> = SmallField<S>;
    fn parameters(&self) -> Vec<f64> {
        self.parameters.clone()
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> SmallField<S> {
        SmallField { rates: self.rates.clone(), states: self.states, parameters: p.to_vec() }
    }
}
