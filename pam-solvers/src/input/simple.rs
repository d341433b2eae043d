use super::{Input, ParametricInput, Side};
use pam_core::Scalar;

/// No input at all.
///
/// ```
/// use pam_solvers::{Input, NoInput};
/// assert_eq!(Input::<f64>::input_len(&NoInput), 0);
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub struct NoInput;

impl<S: Scalar> Input<S> for NoInput {
    fn input_len(&self) -> usize {
        0
    }
    fn value_into(&self, _t: f64, _side: Side, _out: &mut [S]) {}
}

/// No parameters.
impl ParametricInput for NoInput {
    type With<S: Scalar> = NoInput;
    fn parameters(&self) -> Vec<f64> {
        Vec::new()
    }
    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> NoInput {
        assert!(parameters.is_empty(), "no input has no parameters");
        NoInput
    }
    fn vjp_into(&self, _t: f64, _side: Side, _u_cotangent: &[f64], _p_sum: &mut [f64]) {}
    fn jvp_into(&self, _t: f64, _side: Side, _p_tangent: &[f64], _u_tangent: &mut [f64]) {}
}

/// An input that does not change.
///
/// ```
/// use pam_solvers::{Constant, Input, Side};
/// let mut u = [0.0];
/// Constant(vec![100e3]).value_into(0.5, Side::Right, &mut u); // 100 N in mN
/// assert_eq!(u, [100e3]);
/// ```
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

/// Parameters: the values.
impl ParametricInput for Constant<f64> {
    type With<S: Scalar> = Constant<S>;
    fn parameters(&self) -> Vec<f64> {
        self.0.clone()
    }
    fn parameter_len(&self) -> usize {
        self.0.len()
    }
    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Constant<S> {
        assert_eq!(parameters.len(), self.0.len(), "one number for each parameter");
        Constant(parameters.to_vec())
    }
    fn vjp_into(&self, _t: f64, _side: Side, u_cotangent: &[f64], p_sum: &mut [f64]) {
        for (sum, u) in p_sum.iter_mut().zip(u_cotangent) {
            *sum += u;
        }
    }
    fn jvp_into(&self, _t: f64, _side: Side, p_tangent: &[f64], u_tangent: &mut [f64]) {
        u_tangent.copy_from_slice(p_tangent);
    }
}

/// A smooth input from a closure `|t, u|`. It must not jump.
///
/// ```
/// use pam_solvers::{Input, InputFn, Side};
/// let ramp = InputFn::new(1, |t: f64, u: &mut [f64]| u[0] = 3.0 * t);
/// let mut u = [0.0];
/// ramp.value_into(2.0, Side::Right, &mut u);
/// assert_eq!(u, [6.0]);
/// ```
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

/// No parameters: a closure shows none. Write a type with [`ParametricInput`] where the input has some.
impl<F: Fn(f64, &mut [f64]) + Clone> ParametricInput for InputFn<F> {
    type With<S: Scalar> = LiftedInputFn<F>;
    fn parameters(&self) -> Vec<f64> {
        Vec::new()
    }
    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> LiftedInputFn<F> {
        assert!(parameters.is_empty(), "a closure has no parameters");
        LiftedInputFn(self.clone())
    }
    fn vjp_into(&self, _t: f64, _side: Side, _u_cotangent: &[f64], _p_sum: &mut [f64]) {}
    fn jvp_into(&self, _t: f64, _side: Side, _p_tangent: &[f64], u_tangent: &mut [f64]) {
        u_tangent.fill(0.0);
    }
}

/// An [`InputFn`] of plain numbers whose values are constants of any scalar.
#[derive(Debug, Clone, Copy)]
pub struct LiftedInputFn<F>(InputFn<F>);

impl<S: Scalar, F: Fn(f64, &mut [f64])> Input<S> for LiftedInputFn<F> {
    fn input_len(&self) -> usize {
        self.0.input_len
    }
    fn value_into(&self, t: f64, _side: Side, out: &mut [S]) {
        // Only tapes and dual numbers come by here, where one small allocation is not felt.
        let mut values = vec![0.0; self.0.input_len];
        (self.0.function)(t, &mut values);
        for (o, &v) in out.iter_mut().zip(&values) {
            *o = S::constant(v);
        }
    }
}
