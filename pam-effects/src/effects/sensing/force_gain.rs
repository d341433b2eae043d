//! The force is off by a factor.

use crate::effects::{DataScales, Effect, EffectInfo, Group, ParameterInfo};
use pam_core::Scalar;

const INFO: EffectInfo = EffectInfo {
    id: "force_gain",
    group: Group::Sensing,
    what: "real force that differs from the commanded one by a factor",
    parameters: &[ParameterInfo::linear("relative", [-0.9, 5.0])],
    switches: &[],
    air: false,
    excited_by: "motion at frequencies far apart",
};

/// Real force `(1 + relative)` times the commanded one.
#[derive(Debug, Clone, Copy)]
pub struct ForceGain;

impl Effect for ForceGain {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn starts(&self, _evidence: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn drive<S: Scalar>(&self, p: &[S], force_mn: S) -> S {
        force_mn + p[0] * force_mn
    }
}
