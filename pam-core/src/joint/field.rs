use super::{JointModel, MuscleGeometry, PhysicalParameters, RawParameters, SealedMasses};
use super::{ME, MF, PE, PF, V, X, closed_pressure_rate, pressure_rate};
use crate::field::{ParametricField, VectorField};
use crate::force::{ForceInput, ForceModel, ParametricForce};
use crate::scalar::Scalar;

/// How the chambers are closed off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Chambers<S> {
    /// Valves closed: each muscle keeps its air. Four states, one input.
    Sealed(SealedMasses<S>),
    /// Valves open: the air masses are states, driven by the flows ṁ_f, ṁ_e. Six states, three
    /// inputs.
    OpenValves,
}

/// The hybrid vector field of the joint,
///
/// ```text
/// ẋ   = v
/// v̇   = (F_e − f_θ(x, v, m_f, m_e) − B v) / m
/// Ṗ_i = C (ṁ_i / V_i − m_i V̇_i / V_i²)
/// ```
///
/// with `f_θ` the restoring force and `B` the auxiliary damping. With sealed chambers ṁ_i = 0 and
/// the masses are constants; with open valves they are two further states with the rates ṁ_i.
/// Source: Wang and Realmuto 2026, equation (4), with the sign of its published code.
#[derive(Debug, Clone, Copy)]
pub struct JointField<S, F> {
    raw: RawParameters<S>,
    geometry: MuscleGeometry,
    auxiliary_damping_kg_s: S,
    force: F,
    chambers: Chambers<S>,
    physical: PhysicalParameters<S>,
    inverse_mass: S,
}

impl<S: Scalar, F> JointField<S, F> {
    /// The field of `model` with the given chambers; evaluates the softplus once. The model's force
    /// may be a reference.
    pub fn new(model: JointModel<S, F>, chambers: Chambers<S>) -> Self {
        let physical = model.physical();
        Self {
            raw: model.raw,
            geometry: model.geometry,
            auxiliary_damping_kg_s: model.auxiliary_damping_kg_s,
            force: model.force,
            chambers,
            physical,
            inverse_mass: physical.mass_kg.recip(),
        }
    }

    /// How the chambers are closed off.
    pub fn chambers(&self) -> &Chambers<S> {
        &self.chambers
    }

    /// The force model.
    pub fn force(&self) -> &F {
        &self.force
    }

    /// The parameters before softplus.
    pub fn raw(&self) -> &RawParameters<S> {
        &self.raw
    }

    /// The physical parameters.
    pub fn physical(&self) -> &PhysicalParameters<S> {
        &self.physical
    }

    /// Nominal size of the muscles.
    pub fn geometry(&self) -> &MuscleGeometry {
        &self.geometry
    }

    /// Auxiliary damping B, kg/s.
    pub fn auxiliary_damping_kg_s(&self) -> S {
        self.auxiliary_damping_kg_s
    }
}

/// Parameters: those of the force, then raw m, raw C, raw ν (before softplus), B (kg/s), and, for
/// sealed chambers, m_f and m_e (g).
impl<F: ParametricForce> ParametricField for JointField<f64, F> {
    type With<S: Scalar> = JointField<S, F::With<S>>;

    fn parameters(&self) -> Vec<f64> {
        let mut parameters = self.force.parameters();
        let raw = &self.raw;
        parameters.extend([raw.mass, raw.gas_coefficient, raw.deformation]);
        parameters.push(self.auxiliary_damping_kg_s);
        if let Chambers::Sealed(m) = self.chambers {
            parameters.extend([m.flexor_g, m.extensor_g]);
        }
        parameters
    }

    fn parameter_len(&self) -> usize {
        let own = if matches!(self.chambers, Chambers::Sealed(_)) { 6 } else { 4 };
        self.force.parameter_len() + own
    }

    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Self::With<S> {
        assert_eq!(parameters.len(), self.parameter_len(), "one number for each parameter");
        let (force, own) = parameters.split_at(self.force.parameter_len());
        let model = JointModel {
            raw: RawParameters { mass: own[0], gas_coefficient: own[1], deformation: own[2] },
            geometry: self.geometry,
            auxiliary_damping_kg_s: own[3],
            force: self.force.with_parameters(force),
        };
        let chambers = match self.chambers {
            Chambers::Sealed(_) => {
                Chambers::Sealed(SealedMasses { flexor_g: own[4], extensor_g: own[5] })
            }
            Chambers::OpenValves => Chambers::OpenValves,
        };
        JointField::new(model, chambers)
    }
}

impl<S: Scalar, F: ForceModel<S>> VectorField<S> for JointField<S, F> {
    fn state_len(&self) -> usize {
        match self.chambers {
            Chambers::Sealed(_) => 4,
            Chambers::OpenValves => 6,
        }
    }

    fn input_len(&self) -> usize {
        match self.chambers {
            Chambers::Sealed(_) => 1,
            Chambers::OpenValves => 3,
        }
    }

    fn work_len(&self) -> usize {
        self.force.work_len()
    }

    fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], work: &mut [S]) {
        let (x, v) = (y[X], y[V]);
        let (mass_flexor_g, mass_extensor_g) = match self.chambers {
            Chambers::Sealed(m) => (m.flexor_g, m.extensor_g),
            Chambers::OpenValves => (y[MF], y[ME]),
        };
        let input =
            ForceInput { displacement_mm: x, velocity_mm_s: v, mass_flexor_g, mass_extensor_g };
        let restoring = self.force.restoring_force_mn(&input, work);
        dy[X] = v;
        dy[V] = (u[0] - restoring - self.auxiliary_damping_kg_s * v) * self.inverse_mass;

        let c = self.physical.gas_coefficient;
        let volumes = self.geometry.volumes(x, self.physical.deformation);
        let (vf, ve) = (volumes.flexor_mm3, volumes.extensor_mm3);
        let (rate_f, rate_e) = (volumes.flexor_slope_mm2 * v, volumes.extensor_slope_mm2 * v);
        match self.chambers {
            Chambers::Sealed(_) => {
                dy[PF] = closed_pressure_rate(c, mass_flexor_g, vf, rate_f);
                dy[PE] = closed_pressure_rate(c, mass_extensor_g, ve, rate_e);
            }
            Chambers::OpenValves => {
                dy[PF] = pressure_rate(c, mass_flexor_g, u[1], vf, rate_f);
                dy[PE] = pressure_rate(c, mass_extensor_g, u[2], ve, rate_e);
                dy[MF] = u[1];
                dy[ME] = u[2];
            }
        }
    }
}
