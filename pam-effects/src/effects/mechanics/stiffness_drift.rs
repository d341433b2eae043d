//! The restoring force changes with time.

use crate::effects::{DataScales, Effect, EffectInfo, Group, ParameterInfo, Point};
use pam_core::Scalar;

const INFO: EffectInfo = EffectInfo {
    id: "stiffness_drift",
    group: Group::Mechanics,
    what: "restoring force that changes slowly with time",
    parameters: &[ParameterInfo::linear("relative_per_min", [-0.9, 10.0])],
    switches: &[],
    air: false,
    excited_by: "a long recording, or the same motion at its two ends",
};

/// Restoring force `f · (1 + relative · t / 60 s)`.
#[derive(Debug, Clone, Copy)]
pub struct StiffnessDrift;

impl Effect for StiffnessDrift {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn starts(&self, _evidence: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, _memory: &[S]) -> S {
        -(p[0] * at.restoring_mn).scaled(at.time_s / 60.0)
    }
}
