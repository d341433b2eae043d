//! The encoder's zero is off.

use crate::effects::{DataScales, Effect, EffectInfo, Group, Observed, ParameterInfo, Rest};
use pam_core::Scalar;

const INFO: EffectInfo = EffectInfo {
    id: "position_offset",
    group: Group::Sensing,
    what: "offset of the position sensor",
    parameters: &[ParameterInfo::linear("offset_mm", [-20.0, 20.0])],
    switches: &[],
    air: false,
    excited_by: "any motion; told from a steady force by a wide range of pressures",
};

/// Measured displacement is the true one plus an offset.
#[derive(Debug, Clone, Copy)]
pub struct PositionOffset;

impl Effect for PositionOffset {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn starts(&self, _evidence: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn rest<S: Scalar>(&self, p: &[S], rest: &mut Rest<S>) {
        rest.sealed_mm -= p[0];
        rest.start_mm -= p[0];
    }

    fn observe<S: Scalar>(&self, p: &[S], seen: &mut Observed<'_, S>) {
        seen.displacement_mm.iter_mut().for_each(|x| *x += p[0]);
    }
}
