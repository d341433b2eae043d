use super::{ForceInput, ForceModel, Mlp};
use crate::activation::{Activation, ActivationFunction};
use crate::error::ModelError;
use crate::scalar::Scalar;

/// A learned restoring force: a network with inputs `(m_f, m_e, x, ẋ)`, unscaled, and one output in
/// mN. The order is that of the published weights.
#[derive(Debug, Clone, PartialEq)]
pub struct NetworkForce<S, A = Activation> {
    mlp: Mlp<S, A>,
}

impl<S: Scalar, A: ActivationFunction> NetworkForce<S, A> {
    /// Number of inputs of a force network: `(m_f, m_e, x, ẋ)`.
    pub const INPUTS: usize = 4;

    /// Takes a network with four inputs and one output.
    ///
    /// # Errors
    /// [`ModelError::Shape`] for any other network.
    pub fn new(mlp: Mlp<S, A>) -> Result<Self, ModelError> {
        if mlp.inputs() != Self::INPUTS || mlp.outputs() != 1 {
            return Err(ModelError::Shape(format!(
                "a force network maps 4 inputs (m_f, m_e, x, v) to 1 force, this one maps {} to {}",
                mlp.inputs(),
                mlp.outputs()
            )));
        }
        Ok(Self { mlp })
    }

    /// The network itself.
    #[must_use]
    pub fn mlp(&self) -> &Mlp<S, A> {
        &self.mlp
    }

    /// The same force with other numbers, weight by weight.
    pub fn map<T: Scalar>(&self, f: impl FnMut(S) -> T) -> NetworkForce<T, A> {
        NetworkForce { mlp: self.mlp.map(f) }
    }
}

impl<S: Scalar, A: ActivationFunction> ForceModel<S> for NetworkForce<S, A> {
    fn restoring_force_mn(&self, input: &ForceInput<S>, work: &mut [S]) -> S {
        let features = [
            input.mass_flexor_g,
            input.mass_extensor_g,
            input.displacement_mm,
            input.velocity_mm_s,
        ];
        let mut force = [S::zero()];
        self.mlp.forward_into(&features, &mut force, work);
        force[0]
    }

    fn work_len(&self) -> usize {
        self.mlp.work_len()
    }
}
