//! A force proportional to the velocity.

use crate::effects::{Absorbed, DataScales, Effect, EffectInfo, Group, ParameterInfo, Point};
use pam_core::{AnyForce, JointModel, Scalar};

const INFO: EffectInfo = EffectInfo {
    id: "viscous_damping",
    group: Group::Mechanics,
    what: "force proportional to the velocity",
    parameters: &[ParameterInfo::linear("coefficient_ns_m", [-5e3, 1e5])],
    switches: &[],
    air: false,
    excited_by: "fast motion",
};

/// Force `−coefficient · ẋ`.
#[derive(Debug, Clone, Copy)]
pub struct ViscousDamping;

impl Effect for ViscousDamping {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn starts(&self, _evidence: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, _memory: &[S]) -> S {
        // 1 N·s/m = 1 mN·s/mm.
        -(p[0] * at.velocity_mm_s)
    }

    fn absorb(&self, values: &[f64], joint: &mut JointModel<f64, AnyForce<f64>>) -> Absorbed {
        joint.auxiliary_damping_kg_s += values[0];
        Absorbed::Exactly
    }
}
