//! A force proportional to the velocity.

use crate::effects::{Effect, EffectInfo, Evidence, Group, ParameterInfo, Point};
use pam_core::Scalar;

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

    fn starts(&self, _evidence: &Evidence) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, _memory: &[S]) -> S {
        // 1 N·s/m = 1 mN·s/mm.
        -(p[0] * at.velocity_mm_s)
    }
}
