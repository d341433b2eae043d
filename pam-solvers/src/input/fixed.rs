use super::{Input, ParametricInput, Side};
use pam_core::Scalar;

/// An input that is not differentiated by: it has no parameters, whatever the wrapped one has.
///
/// A measured force has as many parameters as samples; forward methods and finite differences would
/// spend a direction on each.
#[derive(Debug, Clone, Copy)]
pub struct Fixed<I>(pub I);

impl<S: Scalar, I: Input<S>> Input<S> for Fixed<I> {
    fn input_len(&self) -> usize {
        self.0.input_len()
    }
    fn value_into(&self, t: f64, side: Side, out: &mut [S]) {
        self.0.value_into(t, side, out);
    }
    fn next_jump(&self, t: f64) -> Option<f64> {
        self.0.next_jump(t)
    }
}

impl<I: ParametricInput> ParametricInput for Fixed<I> {
    type With<S: Scalar> = I::With<S>;

    fn parameters(&self) -> Vec<f64> {
        Vec::new()
    }

    fn parameter_len(&self) -> usize {
        0
    }

    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Self::With<S> {
        assert!(parameters.is_empty(), "a fixed input has no parameters");
        let constants: Vec<S> = self.0.parameters().into_iter().map(S::constant).collect();
        self.0.with_parameters(&constants)
    }

    fn vjp_into(&self, _t: f64, _side: Side, _u: &[f64], _sums: &mut [f64]) {}

    fn jvp_into(&self, _t: f64, _side: Side, _p: &[f64], u: &mut [f64]) {
        u.fill(0.0);
    }
}
