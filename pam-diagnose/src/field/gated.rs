//! A field whose terms come and go.

use pam_core::{DryFriction, FieldNames, ParametricField, Scalar, VectorField};
use pam_vocabulary::ActivityWindow;
use std::cell::RefCell;

/// A term of a field with a course in time: its parameters, between absent and their values.
#[derive(Debug, Clone)]
pub(super) struct Gate {
    /// The parameters that switch it on, with the values at which it is absent.
    pub(super) parameters: Vec<(usize, f64)>,
    /// Which times it has.
    pub(super) course: ActivityWindow,
    /// Place of the first of them among all times.
    pub(super) first: usize,
}

/// A field with the times of its gates as further parameters, counted from `start_s` on.
pub(super) struct Gated<'a, F> {
    field: &'a F,
    gates: Vec<Gate>,
    times: usize,
    start_s: f64,
    ramp_s: f64,
}

impl<'a, F: ParametricField> Gated<'a, F> {
    pub(super) fn new(
        field: &'a F,
        gates: Vec<Gate>,
        times: usize,
        start_s: f64,
        ramp_s: f64,
    ) -> Self {
        Self { field, gates, times, start_s, ramp_s }
    }
}

/// Shares of the gates at which a field was made, and the field.
type Made<V> = RefCell<Option<(Vec<bool>, V)>>;

/// The field over a scalar.
pub(super) struct Switched<'a, F: ParametricField, S: Scalar> {
    field: &'a F,
    gates: Vec<Gate>,
    parameters: Vec<S>,
    times: Vec<S>,
    start_s: f64,
    ramp_s: f64,
    whole: F::With<S>,
    /// The field of the last time at which every term was there or not.
    last: Made<F::With<S>>,
}

impl<F: ParametricField, S: Scalar> Switched<'_, F, S> {
    /// The share of a gate that is there at a time.
    fn share(&self, gate: &Gate, t: f64) -> S {
        let since_s = S::constant(t - self.start_s);
        let mut times = self.times[gate.first..].iter().copied();
        let mut next = |has: bool| if has { times.next() } else { None };
        let (onset, ramp, end) =
            (next(gate.course.onset), next(gate.course.ramp), next(gate.course.end));
        let least = S::constant(self.ramp_s);
        let mut share = S::constant(1.0);
        if let Some(onset) = onset {
            share = pam_core::smooth_step(since_s - onset, ramp.unwrap_or(least));
        }
        if let Some(end) = end {
            share *= pam_core::smooth_step(end - since_s, least);
        }
        share
    }

    /// Calls `then` with the field as it is at a time.
    fn at<R>(&self, t: f64, then: impl FnOnce(&F::With<S>) -> R) -> R {
        let shares: Vec<S> = self.gates.iter().map(|gate| self.share(gate, t)).collect();
        let passing = shares.iter().any(|s| s.real() > 0.0 && s.real() < 1.0);
        let there: Vec<bool> = shares.iter().map(|s| s.real() >= 1.0).collect();
        if !passing && there.iter().all(|t| *t) {
            return then(&self.whole);
        }
        if !passing
            && let Some((known, field)) = &*self.last.borrow()
            && *known == there
        {
            return then(field);
        }
        let mut parameters = self.parameters.clone();
        for (gate, &share) in self.gates.iter().zip(&shares) {
            for &(index, off) in &gate.parameters {
                let off = S::constant(off);
                parameters[index] = off + share * (parameters[index] - off);
            }
        }
        let field = self.field.with_parameters(&parameters);
        let result = then(&field);
        if !passing {
            *self.last.borrow_mut() = Some((there, field));
        }
        result
    }
}

impl<F: ParametricField, S: Scalar> VectorField<S> for Switched<'_, F, S> {
    fn state_len(&self) -> usize {
        self.whole.state_len()
    }
    fn input_len(&self) -> usize {
        self.whole.input_len()
    }
    fn work_len(&self) -> usize {
        self.whole.work_len()
    }
    fn eval_into(&self, t: f64, y: &[S], u: &[S], dy: &mut [S], work: &mut [S]) {
        self.at(t, |field| field.eval_into(t, y, u, dy, work));
    }
    fn output_len(&self) -> usize {
        self.whole.output_len()
    }
    fn outputs_into(&self, t: f64, y: &[S], u: &[S], out: &mut [S]) {
        self.at(t, |field| field.outputs_into(t, y, u, out));
    }
}

impl<F: ParametricField> VectorField<f64> for Gated<'_, F> {
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

impl<'a, F: ParametricField> ParametricField for Gated<'a, F> {
    type With<S: Scalar> = Switched<'a, F, S>;

    fn parameters(&self) -> Vec<f64> {
        let mut all = self.field.parameters();
        all.resize(all.len() + self.times, 0.0);
        all
    }

    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Self::With<S> {
        let (own, times) = parameters.split_at(parameters.len() - self.times);
        Switched {
            field: self.field,
            gates: self.gates.clone(),
            parameters: own.to_vec(),
            times: times.to_vec(),
            start_s: self.start_s,
            ramp_s: self.ramp_s,
            whole: self.field.with_parameters(own),
            last: RefCell::new(None),
        }
    }

    fn names(&self) -> FieldNames {
        self.field.names()
    }

    fn dry_friction(&self) -> Option<DryFriction> {
        self.field.dry_friction()
    }
}
