use crate::error::ModelError;
use crate::scalar::Scalar;
use crate::units;

/// The three physical parameters, all positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhysicalParameters<S = f64> {
    /// Reflected mass m, kg.
    pub mass_kg: S,
    /// Gas coefficient C = R T / m_air, kPa·mm³/g.
    pub gas_coefficient: S,
    /// Deformation coefficient ν of the braid.
    pub deformation: S,
}

impl PhysicalParameters<f64> {
    /// Datasheet values: m = I/r_p² = 253.9 kg, C = 8.47e7 kPa·mm³/g, ν = cot²(25°) = 4.60.
    #[must_use]
    pub fn datasheet() -> Self {
        Self {
            mass_kg: units::datasheet_reflected_mass_kg(),
            gas_coefficient: units::GAS_COEFFICIENT_KPA_MM3_PER_G,
            deformation: units::datasheet_deformation_coefficient(),
        }
    }

    /// Checks all three.
    ///
    /// # Errors
    /// [`ModelError::NotPositive`] if one is not positive and finite, [`ModelError::OutOfRange`] if one is far beyond
    /// any joint: its equations could not be solved in any time.
    pub fn validate(&self) -> Result<(), ModelError> {
        ModelError::require_positive("reflected mass (kg)", self.mass_kg)?;
        ModelError::require_positive("gas coefficient (kPa mm3/g)", self.gas_coefficient)?;
        ModelError::require_positive("deformation coefficient", self.deformation)?;
        ModelError::require_within("reflected mass (kg)", self.mass_kg, [1e-6, 1e9])?;
        ModelError::require_within(
            "gas coefficient (kPa mm3/g)",
            self.gas_coefficient,
            [1.0, 1e15],
        )?;
        ModelError::require_within("deformation coefficient", self.deformation, [1e-12, 1e3])
    }
}

impl<S: Scalar> PhysicalParameters<S> {
    /// The unconstrained values whose softplus these are.
    #[must_use]
    pub fn to_raw(self) -> RawParameters<S> {
        RawParameters {
            mass: self.mass_kg.softplus_inverse(),
            gas_coefficient: self.gas_coefficient.softplus_inverse(),
            deformation: self.deformation.softplus_inverse(),
        }
    }
}

/// The unconstrained values that training moves; the physical ones are their softplus, which keeps
/// them positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RawParameters<S = f64> {
    /// Before softplus: reflected mass.
    pub mass: S,
    /// Before softplus: gas coefficient.
    pub gas_coefficient: S,
    /// Before softplus: deformation coefficient.
    pub deformation: S,
}

impl<S: Scalar> RawParameters<S> {
    /// The physical parameters, `softplus(raw)`.
    #[must_use]
    pub fn physical(&self) -> PhysicalParameters<S> {
        PhysicalParameters {
            mass_kg: self.mass.softplus(),
            gas_coefficient: self.gas_coefficient.softplus(),
            deformation: self.deformation.softplus(),
        }
    }

    /// The same parameters with other numbers.
    pub fn map<T>(&self, mut f: impl FnMut(S) -> T) -> RawParameters<T> {
        RawParameters {
            mass: f(self.mass),
            gas_coefficient: f(self.gas_coefficient),
            deformation: f(self.deformation),
        }
    }
}
