use crate::scalar::Scalar;

/// The arguments of a force model: the mechanical state and the air in each muscle.
///
/// ```
/// use pam_core::{ForceInput, ForceModel, SpringDamper};
///
/// let at = ForceInput {
///     displacement_mm: 1.0,
///     velocity_mm_s: 0.0,
///     mass_flexor_g: 0.08,
///     mass_extensor_g: 0.08,
/// };
/// let newtons = 1e-3 * SpringDamper::<f64>::published().restoring_force_mn(&at, &mut []);
/// assert!((100.0..200.0).contains(&newtons)); // the restoring force at 1 mm
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceInput<S> {
    /// Tendon displacement x, mm; positive shortens the flexor.
    pub displacement_mm: S,
    /// Velocity ẋ, mm/s.
    pub velocity_mm_s: S,
    /// Air in the flexor m_f, g.
    pub mass_flexor_g: S,
    /// Air in the extensor m_e, g.
    pub mass_extensor_g: S,
}

impl<S: Scalar> ForceInput<S> {
    /// The same operating point with another scalar, as constants.
    pub fn lift<T: Scalar>(&self) -> ForceInput<T>
    where
        S: Into<f64>,
    {
        ForceInput {
            displacement_mm: T::constant(self.displacement_mm.into()),
            velocity_mm_s: T::constant(self.velocity_mm_s.into()),
            mass_flexor_g: T::constant(self.mass_flexor_g.into()),
            mass_extensor_g: T::constant(self.mass_extensor_g.into()),
        }
    }
}
