//! The base model in a simulation.

use crate::effects::Restoring;
use pam_core::{JointModel, MuscleGeometry, Scalar};

/// The base model's own numbers.
#[derive(Debug, Clone, Copy)]
pub struct Base<S> {
    /// Mass m, kg.
    pub mass_kg: S,
    /// Deformation coefficient ν.
    pub deformation: S,
    /// Gas coefficient C, kPa·mm³/g.
    pub gas_coefficient: S,
    /// Auxiliary damping B, kg/s.
    pub damping_kg_s: S,
    /// Nominal size.
    pub geometry: MuscleGeometry,
}

impl Base<f64> {
    /// The numbers of a model.
    #[must_use]
    pub fn of<F>(model: &JointModel<f64, F>) -> Self {
        let p = model.physical();
        Self {
            mass_kg: p.mass_kg,
            deformation: p.deformation,
            gas_coefficient: p.gas_coefficient,
            damping_kg_s: model.auxiliary_damping_kg_s,
            geometry: model.geometry,
        }
    }
}

impl<S: Scalar> Base<S> {
    /// The numbers without their derivatives.
    #[must_use]
    pub fn real(&self) -> Base<f64> {
        Base {
            mass_kg: self.mass_kg.real(),
            deformation: self.deformation.real(),
            gas_coefficient: self.gas_coefficient.real(),
            damping_kg_s: self.damping_kg_s.real(),
            geometry: self.geometry,
        }
    }
}

/// A source of the base model's force.
pub(crate) trait BaseForce<S: Scalar> {
    /// The force with given air.
    type Sealed<'a>: SealedForce<S>
    where
        Self: 'a;

    /// The force with these masses sealed in, g.
    fn sealed(&self, air_g: [S; 2]) -> Self::Sealed<'_>;
}

/// The base model's force with given air, in the equation of motion.
pub(crate) trait SealedForce<S: Scalar>: Restoring<S> {
    /// The acceleration (mm/s²) at a displacement (mm) and velocity (mm/s) under a further force `push_mn` and a damping.
    #[inline]
    fn acceleration(&self, [x, v]: [&S; 2], push_mn: &S, damping_kg_s: &S, per_kg: &S) -> S {
        (*push_mn - self.restoring_mn(*x, *v) - *v * *damping_kg_s) * *per_kg
    }
}
