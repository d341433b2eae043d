//! The equilibrium-point model of [`pam_control::equilibrium_point`] as a model of motion.
//!
//! ```text
//! m ẍ = F − K (x − x0) − B ẋ     x0 = α1 (P_f − P_e) + α0     K = β1 (P_f + P_e) + β0
//! ```
//!
//! with the sealed pressures P_f and P_e at rest. Position and stiffness come from the equilibria and
//! stiffnesses of the training recordings, as published; m and B from the force that is then left.

use crate::error::BaselineError;
use crate::joint::{JointBaseline, JointForce, gas_of};
use crate::method::{FittedModel, Method, Structure, TrainingSet};
use crate::points::motion_points;
use pam_control::equilibrium_point::{EquilibriumPoint, Observation, observe};
use pam_core::parallel;
use pam_core::units::MN_PER_N;
use pam_core::{ForceInput, ForceModel, MuscleGeometry, Scalar};
use pam_data::formats::npz::Array;
use pam_numerics::least_squares;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Distance of the points that mass and damping are regressed on, s.
const SPACING_S: f64 = 0.01;

/// The equilibrium-point model.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EquilibriumModel {}

/// Its force. Pressures at rest follow from the sealed masses by the gas law at x = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EquilibriumForce {
    /// The published model.
    pub point: EquilibriumPoint,
    /// Damping B, kg/s.
    pub damping_kg_s: f64,
    /// Pressure of a gram of air at x = 0, kPa/g.
    pub pressure_per_mass_kpa_g: f64,
}

impl EquilibriumForce {
    fn stiffness_and_rest<S: Scalar>(&self, flexor_kpa: S, extensor_kpa: S) -> (S, S) {
        let p = &self.point;
        let rest =
            (flexor_kpa - extensor_kpa).scaled(p.position_per_kpa) + S::constant(p.position_mm);
        let stiffness =
            (flexor_kpa + extensor_kpa).scaled(p.stiffness_per_kpa) + S::constant(p.stiffness_n_mm);
        (stiffness.scaled(MN_PER_N), rest)
    }
}

impl<S: Scalar> ForceModel<S> for EquilibriumForce {
    fn restoring_force_mn(&self, at: &ForceInput<S>, _work: &mut [S]) -> S {
        let kpa = |mass: S| mass.scaled(self.pressure_per_mass_kpa_g);
        let (stiffness, rest) =
            self.stiffness_and_rest(kpa(at.mass_flexor_g), kpa(at.mass_extensor_g));
        stiffness * (at.displacement_mm - rest) + at.velocity_mm_s.scaled(self.damping_kg_s)
    }
}

impl JointForce for EquilibriumForce {
    type Dual = Self;

    fn dual(&self) -> Self::Dual {
        *self
    }

    fn parameter_count(&self) -> usize {
        5
    }

    fn structure(&self) -> Structure {
        Structure::Physical
    }

    fn details(&self) -> Value {
        json!({ "equilibrium_point": self.point, "damping_kg_s": self.damping_kg_s })
    }

    fn arrays(&self) -> BTreeMap<String, Array> {
        let p = &self.point;
        let values = vec![
            p.position_per_kpa,
            p.position_mm,
            p.stiffness_per_kpa,
            p.stiffness_n_mm,
            self.damping_kg_s,
            self.pressure_per_mass_kpa_g,
        ];
        BTreeMap::from([("equilibrium_point".into(), Array::vector(values))])
    }
}

impl Method for EquilibriumModel {
    fn title(&self) -> String {
        "Equilibrium point".into()
    }

    fn fit(
        &self,
        training: &TrainingSet<'_>,
        _progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Box<dyn FittedModel>, BaselineError> {
        let observed: Vec<_> =
            parallel::map(training.subjects.len(), |k| observe(&training.subjects[k].recording));
        // Recordings that do not show a stiffness say nothing of it.
        let observations: Vec<Observation> = observed.into_iter().filter_map(Result::ok).collect();
        let point = EquilibriumPoint::fit(&observations)?;
        let mut physical = gas_of(training.subjects);
        let volume = MuscleGeometry::default().volumes(0.0, physical.deformation).flexor_mm3;
        let mut force = EquilibriumForce {
            point,
            damping_kg_s: 0.0,
            pressure_per_mass_kpa_g: physical.gas_coefficient / volume,
        };
        let rows = training.subjects.iter().flat_map(|s| {
            let rest = s.recording.reading_at_rest();
            let (stiffness, x0) =
                force.stiffness_and_rest(rest.pressure_flexor_kpa, rest.pressure_extensor_kpa);
            motion_points(&s.recording, SPACING_S).into_iter().map(move |p| {
                let left = p.force_mn - stiffness * (p.displacement_mm - x0);
                ([p.acceleration_mm_s2, p.velocity_mm_s], left)
            })
        });
        let found = least_squares(rows, 0.0).filter(|[mass, _]| *mass > 0.0);
        let [mass, damping] = found.ok_or_else(|| {
            BaselineError::unfit("Equilibrium point", "the training recordings show no mass")
        })?;
        physical.mass_kg = mass;
        force.damping_kg_s = damping;
        Ok(Box::new(JointBaseline::new(physical, force)?))
    }
}
