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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::SpringDamper;
    use approx::assert_relative_eq;
    use num_dual::Dual64;

    fn model() -> JointModel<f64, SpringDamper<f64>> {
        let mut model = JointModel::datasheet(SpringDamper::constant(150e3, 6000.0));
        model.auxiliary_damping_kg_s = 500.0;
        model
    }

    fn masses() -> SealedMasses {
        SealedMasses::new(0.06, 0.08).unwrap()
    }

    #[test]
    fn the_learned_force_restores() {
        let model = model();
        let field = model.sealed(masses());
        let mut dy = [0.0; 4];
        field.eval_into(0.0, &[1.0, 0.0, 300.0, 300.0], &[0.0], &mut dy, &mut []);
        assert!(dy[V] < 0.0, "a displaced joint is pulled back");
        assert_relative_eq!(dy[V], -150e3 / model.physical().mass_kg, max_relative = 1e-14);
        field.eval_into(0.0, &[0.0, 2.0, 300.0, 300.0], &[7.0e3], &mut dy, &mut []);
        let expected = (7.0e3 - 6500.0 * 2.0) / model.physical().mass_kg;
        assert_relative_eq!(dy[V], expected, max_relative = 1e-14);
    }

    #[test]
    fn pressure_rates_are_the_time_derivative_of_the_gas_law() {
        let model = model();
        let (x, v) = (0.8, -3.0);
        let [pf, pe] = model.gas_law_pressures_kpa(x, masses());
        let mut dy = [0.0; 4];
        model.sealed(masses()).eval_into(0.0, &[x, v, pf, pe], &[0.0], &mut dy, &mut []);
        let lifted = model.map(Dual64::constant, |f| f.map(Dual64::constant));
        let along = lifted.gas_law_pressures_kpa(Dual64::new(x, v), masses().lift());
        assert_relative_eq!(dy[PF], along[0].eps, max_relative = 1e-12);
        assert_relative_eq!(dy[PE], along[1].eps, max_relative = 1e-12);
    }

    #[test]
    fn open_valves_add_the_flow_terms() {
        let model = model();
        let (x, v) = (0.3, 1.5);
        let m = masses();
        let [pf, pe] = model.gas_law_pressures_kpa(x, m);
        let y = [x, v, pf, pe, m.flexor_g, m.extensor_g];
        let flows = [0.02, -0.01];
        let mut open = [0.0; 6];
        let field = model.with_open_valves();
        field.eval_into(0.0, &y, &[100.0, flows[0], flows[1]], &mut open, &mut []);
        // d/dt (C m / V) along x + v t, m + ṁ t.
        let lifted = model.map(Dual64::constant, |f| f.map(Dual64::constant));
        let along = lifted.gas_law_pressures_kpa(
            Dual64::new(x, v),
            SealedMasses {
                flexor_g: Dual64::new(m.flexor_g, flows[0]),
                extensor_g: Dual64::new(m.extensor_g, flows[1]),
            },
        );
        assert_relative_eq!(open[PF], along[0].eps, max_relative = 1e-12);
        assert_relative_eq!(open[PE], along[1].eps, max_relative = 1e-12);
        assert_eq!([open[MF], open[ME]], flows);
    }
}
