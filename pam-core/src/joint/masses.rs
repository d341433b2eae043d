use crate::error::ModelError;
use crate::scalar::Scalar;

/// The air sealed in the two muscles, g.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SealedMasses<S = f64> {
    /// Air in the flexor m_f, g.
    pub flexor_g: S,
    /// Air in the extensor m_e, g.
    pub extensor_g: S,
}

impl SealedMasses<f64> {
    /// Two masses that are positive and finite.
    ///
    /// # Errors
    /// [`ModelError::NotPositive`] otherwise.
    pub fn new(flexor_g: f64, extensor_g: f64) -> Result<Self, ModelError> {
        ModelError::require_positive("flexor air mass (g)", flexor_g)?;
        ModelError::require_positive("extensor air mass (g)", extensor_g)?;
        Ok(Self { flexor_g, extensor_g })
    }

    /// The same masses as constants of another scalar.
    #[must_use]
    pub fn lift<S: Scalar>(&self) -> SealedMasses<S> {
        SealedMasses {
            flexor_g: S::constant(self.flexor_g),
            extensor_g: S::constant(self.extensor_g),
        }
    }
}
