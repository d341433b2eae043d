use super::{Input, Side};
use pam_core::Scalar;

/// An input `u(t; q)` with parameters `q`, so that a loss can be differentiated with respect to what
/// drives the field: samples of a force, amplitudes, times of flow pulses seen through their heights.
///
/// The times at which the input jumps must not depend on the parameters; a jump time is a step end,
/// and step ends are held fixed by every gradient here.
///
/// ```
/// use pam_core::Scalar;
/// use pam_solvers::{Input, ParametricInput, Side};
///
/// /// `u = a sin(2 t)`
/// struct Sine<S> {
///     amplitude: S,
/// }
///
/// impl<S: Scalar> Input<S> for Sine<S> {
///     fn input_len(&self) -> usize {
///         1
///     }
///     fn value_into(&self, t: f64, _side: Side, out: &mut [S]) {
///         out[0] = self.amplitude.scaled((2.0 * t).sin());
///     }
/// }
///
/// impl ParametricInput for Sine<f64> {
///     type With<S: Scalar> = Sine<S>;
///     fn parameters(&self) -> Vec<f64> {
///         vec![self.amplitude]
///     }
///     fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Sine<S> {
///         Sine { amplitude: parameters[0] }
///     }
///     fn vjp_into(&self, t: f64, _side: Side, u_cotangent: &[f64], p_sum: &mut [f64]) {
///         p_sum[0] += (2.0 * t).sin() * u_cotangent[0];
///     }
///     fn jvp_into(&self, t: f64, _side: Side, p_tangent: &[f64], u_tangent: &mut [f64]) {
///         u_tangent[0] = (2.0 * t).sin() * p_tangent[0];
///     }
/// }
/// ```
#[diagnostic::on_unimplemented(
    message = "the numbers of the input `{Self}` cannot be exchanged",
    label = "an input that a gradient can be taken with is needed here",
    note = "`NoInput`, `Constant` and `Fixed(…)` around any other input are such; implement `ParametricInput` to \
            differentiate by numbers of the input"
)]
pub trait ParametricInput: Input<f64> {
    /// The same input over another scalar.
    type With<S: Scalar>: Input<S>;

    /// The parameters as they are, in the input's fixed order.
    fn parameters(&self) -> Vec<f64>;

    /// Number of parameters.
    fn parameter_len(&self) -> usize {
        self.parameters().len()
    }

    /// The input with other numbers, given in the order of [`parameters`](Self::parameters).
    ///
    /// # Panics
    /// If there are not [`parameter_len`](Self::parameter_len) of them.
    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Self::With<S>;

    /// *Adds* `(∂u/∂q)ᵀ ū` at `t`, approached from `side`, to `p_sum`, for the cotangent `ū` of the
    /// input.
    fn vjp_into(&self, t: f64, side: Side, u_cotangent: &[f64], p_sum: &mut [f64]);

    /// Writes `∂u/∂q · q̇` at `t`, approached from `side`, to `u_tangent`.
    fn jvp_into(&self, t: f64, side: Side, p_tangent: &[f64], u_tangent: &mut [f64]);
}

impl<I: ParametricInput> ParametricInput for &I {
    type With<S: Scalar> = I::With<S>;
    fn parameters(&self) -> Vec<f64> {
        (**self).parameters()
    }
    fn parameter_len(&self) -> usize {
        (**self).parameter_len()
    }
    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Self::With<S> {
        (**self).with_parameters(parameters)
    }
    fn vjp_into(&self, t: f64, side: Side, u_cotangent: &[f64], p_sum: &mut [f64]) {
        (**self).vjp_into(t, side, u_cotangent, p_sum);
    }
    fn jvp_into(&self, t: f64, side: Side, p_tangent: &[f64], u_tangent: &mut [f64]) {
        (**self).jvp_into(t, side, p_tangent, u_tangent);
    }
}
