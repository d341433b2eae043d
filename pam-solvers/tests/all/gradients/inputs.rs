//! A user-written input with parameters, and all inputs as one type.

use pam_core::Scalar;
use pam_solvers::{Constant, Input, NoInput, ParametricInput, SampledInput, Side};

/// `u = a sin(ω t + φ)`, parameters a, ω, φ.
pub(crate) struct Sine<S> {
    pub(crate) amplitude: S,
    pub(crate) frequency: S,
    pub(crate) phase: S,
}

impl<S: Scalar> Input<S> for Sine<S> {
    fn input_len(&self) -> usize {
        1
    }
    fn value_into(&self, t: f64, _side: Side, out: &mut [S]) {
        out[0] = self.amplitude * (self.frequency.scaled(t) + self.phase).sin();
    }
}

impl Sine<f64> {
    /// `∂u/∂(a, ω, φ)`.
    fn slope(&self, t: f64) -> [f64; 3] {
        let (sin, cos) = (self.frequency * t + self.phase).sin_cos();
        [sin, self.amplitude * t * cos, self.amplitude * cos]
    }
}

impl ParametricInput for Sine<f64> {
    type With<S: Scalar> = Sine<S>;
    fn parameters(&self) -> Vec<f64> {
        vec![self.amplitude, self.frequency, self.phase]
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> Sine<S> {
        Sine { amplitude: p[0], frequency: p[1], phase: p[2] }
    }
    fn vjp_into(&self, t: f64, _side: Side, u_cotangent: &[f64], p_sum: &mut [f64]) {
        for (sum, slope) in p_sum.iter_mut().zip(self.slope(t)) {
            *sum += slope * u_cotangent[0];
        }
    }
    fn jvp_into(&self, t: f64, _side: Side, p_tangent: &[f64], u_tangent: &mut [f64]) {
        u_tangent[0] = p_tangent.iter().zip(self.slope(t)).map(|(p, s)| p * s).sum();
    }
}

/// One type for all inputs, so that the gradient methods are instantiated once.
pub(crate) enum AnyInput<'a, S: Clone> {
    None(NoInput),
    Constant(Constant<S>),
    Sampled(SampledInput<'a, S>),
    Sine(Sine<S>),
}

/// Forwards a call to the input.
macro_rules! delegate {
    ($self:ident, $input:ident => $call:expr) => {
        match $self {
            AnyInput::None($input) => $call,
            AnyInput::Constant($input) => $call,
            AnyInput::Sampled($input) => $call,
            AnyInput::Sine($input) => $call,
        }
    };
}

impl<S: Scalar> Input<S> for AnyInput<'_, S> {
    fn input_len(&self) -> usize {
        delegate!(self, input => Input::<S>::input_len(input))
    }
    fn value_into(&self, t: f64, side: Side, out: &mut [S]) {
        delegate!(self, input => input.value_into(t, side, out));
    }
    fn next_jump(&self, t: f64) -> Option<f64> {
        delegate!(self, input => Input::<S>::next_jump(input, t))
    }
}

impl<'a> ParametricInput for AnyInput<'a, f64> {
    type With<S: Scalar> = AnyInput<'a, S>;
    fn parameters(&self) -> Vec<f64> {
        delegate!(self, input => input.parameters())
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> AnyInput<'a, S> {
        match self {
            Self::None(input) => AnyInput::None(input.with_parameters(p)),
            Self::Constant(input) => AnyInput::Constant(input.with_parameters(p)),
            Self::Sampled(input) => AnyInput::Sampled(input.with_parameters(p)),
            Self::Sine(input) => AnyInput::Sine(input.with_parameters(p)),
        }
    }
    fn vjp_into(&self, t: f64, side: Side, u_cotangent: &[f64], p_sum: &mut [f64]) {
        delegate!(self, input => input.vjp_into(t, side, u_cotangent, p_sum));
    }
    fn jvp_into(&self, t: f64, side: Side, p_tangent: &[f64], u_tangent: &mut [f64]) {
        delegate!(self, input => input.jvp_into(t, side, p_tangent, u_tangent));
    }
}
