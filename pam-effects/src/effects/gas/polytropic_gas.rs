//! Pressure with another exponent of the volume.

use crate::effects::{ChamberLaw, DataScales, Effect, EffectInfo, Group, ParameterInfo};
use pam_core::Scalar;

const INFO: EffectInfo = EffectInfo {
    id: "polytropic_gas",
    group: Group::Gas,
    what: "pressure that follows a higher power of the volume",
    parameters: &[ParameterInfo::linear("exponent", [0.5, 2.0]).off_at(Some(1.0))],
    switches: &["force_feedback"],
    air: true,
    excited_by: "motion far from the middle, where the exponent and the geometry differ",
};

/// `P Vⁿ` constant, with or without the force of the changed pressure on the joint.
#[derive(Debug, Clone, Copy)]
pub struct PolytropicGas;

impl Effect for PolytropicGas {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn starts(&self, _evidence: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![1.0, 0.0], vec![1.0, 1.0]]
    }

    fn chamber<S: Scalar>(&self, p: &[S], law: &mut ChamberLaw<S>) {
        law.exponent *= p[0];
        law.feeds_back |= p[1].real() > 0.5;
    }
}
