//! The deformation coefficient is off.

use crate::effects::{Absorbed, ChamberLaw, DataScales, Effect, EffectInfo, Group, ParameterInfo};
use pam_core::{AnyForce, JointModel, PhysicalParameters, Scalar};

const INFO: EffectInfo = EffectInfo {
    id: "geometry_coefficient",
    group: Group::Gas,
    what: "deformation coefficient nu that is off by a factor",
    parameters: &[ParameterInfo::linear("relative", [-0.6, 2.0])],
    switches: &["force_feedback"],
    air: true,
    excited_by: "motion far from the middle, where the exponent and the geometry differ",
};

/// `ν (1 + relative)` in the volumes, with or without the force of the changed pressure on the joint.
#[derive(Debug, Clone, Copy)]
pub struct GeometryCoefficient;

impl Effect for GeometryCoefficient {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn starts(&self, _evidence: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0, 0.0], vec![0.0, 1.0]]
    }

    fn chamber<S: Scalar>(&self, p: &[S], law: &mut ChamberLaw<S>) {
        law.deformation_factor *= p[0] + S::constant(1.0);
        law.feeds_back |= p[1].real() > 0.5;
    }

    fn absorb(&self, values: &[f64], joint: &mut JointModel<f64, AnyForce<f64>>) -> Absorbed {
        // The force of the changed pressures on the joint is none of the network's.
        if values[1] > 0.5 {
            return Absorbed::LeftOut;
        }
        let physical = joint.physical();
        let deformation = physical.deformation * (1.0 + values[0]);
        joint.raw = PhysicalParameters { deformation, ..physical }.to_raw();
        Absorbed::Exactly
    }
}
