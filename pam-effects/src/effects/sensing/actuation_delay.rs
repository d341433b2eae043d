//! The force comes late.

use crate::effects::{DataScales, Effect, EffectInfo, Group, ParameterInfo};
use pam_core::Scalar;

const INFO: EffectInfo = EffectInfo {
    id: "actuation_delay",
    group: Group::Sensing,
    what: "force that follows the recorded one late",
    parameters: &[ParameterInfo::linear("delay_ms", [0.0, 500.0])],
    switches: &[],
    air: false,
    excited_by: "fast motion",
};

/// Real force at t is the recorded one at `t − delay`.
#[derive(Debug, Clone, Copy)]
pub struct ActuationDelay;

impl Effect for ActuationDelay {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn starts(&self, _evidence: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![1.0], vec![20.0]]
    }

    fn delay_s<S: Scalar>(&self, p: &[S]) -> S {
        p[0].scaled(1e-3)
    }
}
