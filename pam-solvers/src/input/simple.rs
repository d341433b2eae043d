use super::{Input, Side};
use pam_core::Scalar;

/// No input at all.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoInput;

impl<S: Scalar> Input<S> for NoInput {
    fn input_len(&self) -> usize {
        0
    }
    fn value_into(&self, _t: f64, _side: Side, _out: &mut [S]) {}
}

/// An input that does not change.
#[derive(Debug, Clone)]
pub struct Constant<S>(pub Vec<S>);

impl<S: Scalar> Input<S> for Constant<S> {
    fn input_len(&self) -> usize {
        self.0.len()
    }
    fn value_into(&self, _t: f64, _side: Side, out: &mut [S]) {
        out.copy_from_slice(&self.0);
    }
}

/// A smooth input from a closure `|t, u|`. It must not jump.
#[derive(Debug, Clone, Copy)]
pub struct InputFn<F> {
    input_len: usize,
    function: F,
}

impl<F> InputFn<F> {
    /// An input of `input_len` variables.
    pub fn new(input_len: usize, function: F) -> Self {
        Self { input_len, function }
    }
}

impl<S: Scalar, F: Fn(f64, &mut [S])> Input<S> for InputFn<F> {
    fn input_len(&self) -> usize {
        self.input_len
    }
    fn value_into(&self, t: f64, _side: Side, out: &mut [S]) {
        (self.function)(t, out);
    }
}
