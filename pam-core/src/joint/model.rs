use super::{
    Chambers, JointField, MuscleGeometry, PhysicalParameters, RawParameters, SealedMasses,
};
use crate::error::ModelError;
use crate::force::ForceModel;
use crate::scalar::Scalar;

/// A hybrid model of the joint: known mechanics and gas, and any force model for the rest.
///
/// The model holds what is learned or known of the joint itself; what belongs to one recording
/// (sealed masses, or open valves) is chosen when a vector field is made of it with
/// [`sealed`](JointModel::sealed) or [`with_open_valves`](JointModel::with_open_valves).
///
/// ```
/// use pam_core::{JointModel, SpringDamper, VectorField};
///
/// let model = JointModel::datasheet(SpringDamper::<f64>::published());
/// let masses = model.gas_law_masses(0.0, [308.0, 515.0]); // kPa absolute, at x = 0
/// let [flexor, extensor] = model.gas_law_pressures_kpa(1.0, masses); // the same air at x = 1 mm
/// assert!(flexor < 308.0 && extensor > 515.0); // a shorter muscle is wider and holds more
/// let field = model.sealed(masses); // for `pam_solvers::Term`
/// assert_eq!((field.state_len(), field.input_len()), (4, 1)); // [x, ẋ, P_f, P_e] and the force
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct JointModel<S, F> {
    /// Mass, gas coefficient and deformation coefficient before softplus.
    pub raw: RawParameters<S>,
    /// Nominal size of the muscles.
    pub geometry: MuscleGeometry,
    /// Auxiliary damping B, kg/s: prescribed during training, zero in a finished model.
    pub auxiliary_damping_kg_s: S,
    /// The restoring force.
    pub force: F,
}

impl<S: Scalar, F> JointModel<S, F> {
    /// A model with datasheet parameters and geometry, no auxiliary damping, and the given force.
    pub fn datasheet(force: F) -> Self {
        Self {
            raw: PhysicalParameters::datasheet().to_raw().map(S::constant),
            geometry: MuscleGeometry::default(),
            auxiliary_damping_kg_s: S::zero(),
            force,
        }
    }

    /// The physical parameters, `softplus(raw)`.
    #[must_use]
    pub fn physical(&self) -> PhysicalParameters<S> {
        self.raw.physical()
    }

    /// The same model with its force borrowed.
    fn borrowed(&self) -> JointModel<S, &F> {
        JointModel {
            raw: self.raw,
            geometry: self.geometry,
            auxiliary_damping_kg_s: self.auxiliary_damping_kg_s,
            force: &self.force,
        }
    }

    /// The same model with other numbers: `number` maps the joint's own parameters and `force`
    /// maps the force model. With constants of a dual type this makes a model that differentiates.
    pub fn map<T: Scalar, G>(
        &self,
        mut number: impl FnMut(S) -> T,
        force: impl FnOnce(&F) -> G,
    ) -> JointModel<T, G> {
        JointModel {
            raw: self.raw.map(&mut number),
            geometry: self.geometry,
            auxiliary_damping_kg_s: number(self.auxiliary_damping_kg_s),
            force: force(&self.force),
        }
    }
}

impl<S: Scalar, F: ForceModel<S>> JointModel<S, F> {
    /// The vector field with closed valves: states `[x, ẋ, P_f, P_e]`, input `[F_e]` (mN).
    pub fn sealed(&self, masses: SealedMasses<S>) -> JointField<S, &F> {
        JointField::new(self.borrowed(), Chambers::Sealed(masses))
    }

    /// The vector field with open valves: states `[x, ẋ, P_f, P_e, m_f, m_e]`, inputs
    /// `[F_e, ṁ_f, ṁ_e]` (mN, g/s, g/s).
    pub fn with_open_valves(&self) -> JointField<S, &F> {
        JointField::new(self.borrowed(), Chambers::OpenValves)
    }

    /// The masses that give `pressures_kpa` (flexor, extensor; absolute) at displacement `x`,
    /// `m_i = P_i V_i(x) / C`.
    pub fn gas_law_masses(&self, x: S, pressures_kpa: [S; 2]) -> SealedMasses<S> {
        let p = self.physical();
        let v = self.geometry.volumes(x, p.deformation);
        SealedMasses {
            flexor_g: super::sealed_mass_g(p.gas_coefficient, pressures_kpa[0], v.flexor_mm3),
            extensor_g: super::sealed_mass_g(p.gas_coefficient, pressures_kpa[1], v.extensor_mm3),
        }
    }

    /// The pressures of sealed air at displacement `x`, `P_i = C m_i / V_i(x)`, kPa absolute.
    pub fn gas_law_pressures_kpa(&self, x: S, masses: SealedMasses<S>) -> [S; 2] {
        let p = self.physical();
        let v = self.geometry.volumes(x, p.deformation);
        [
            super::sealed_pressure_kpa(p.gas_coefficient, masses.flexor_g, v.flexor_mm3),
            super::sealed_pressure_kpa(p.gas_coefficient, masses.extensor_g, v.extensor_mm3),
        ]
    }
}

impl<F> JointModel<f64, F> {
    /// Checks that parameters and geometry are physical.
    ///
    /// # Errors
    /// [`ModelError::NotPositive`] or [`ModelError::OutOfRange`] naming the quantity.
    pub fn validate(&self) -> Result<(), ModelError> {
        self.geometry.validate()?;
        let damping_kg_s = self.auxiliary_damping_kg_s;
        ModelError::require_within("auxiliary damping (kg/s)", damping_kg_s, [0.0, 1e12])?;
        self.physical().validate()
    }
}
