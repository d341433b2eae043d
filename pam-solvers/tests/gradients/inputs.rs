//! A user-written input with parameters.

use pam_core::Scalar;
use pam_solvers::{Input, ParametricInput, Side};

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
