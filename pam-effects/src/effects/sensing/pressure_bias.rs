//! The pressure sensors have an offset.

use crate::effects::{DataScales, Effect, EffectInfo, Group, Observed, ParameterInfo, Rest};
use pam_core::Scalar;

const INFO: EffectInfo = EffectInfo {
    id: "pressure_bias",
    group: Group::Sensing,
    what: "offset of the pressure sensors",
    parameters: &[
        ParameterInfo::linear("flexor_kpa", [-60.0, 60.0]),
        ParameterInfo::linear("extensor_kpa", [-60.0, 60.0]),
    ],
    switches: &[],
    air: false,
    excited_by: "a wide range of pressures",
};

/// Measured pressure is the true one plus a bias; the sealed masses follow from true pressures.
#[derive(Debug, Clone, Copy)]
pub struct PressureBias;

impl Effect for PressureBias {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn starts(&self, _evidence: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0, 0.0]]
    }

    fn rest<S: Scalar>(&self, p: &[S], rest: &mut Rest<S>) {
        for (i, &bias) in p.iter().enumerate() {
            rest.sealed_kpa[i] -= bias;
            rest.start_kpa[i] -= bias;
        }
    }

    fn observe<S: Scalar>(&self, p: &[S], seen: &mut Observed<'_, S>) {
        for (series, &bias) in seen.pressures_kpa.iter_mut().zip(p) {
            series.iter_mut().for_each(|p| *p += bias);
        }
    }
}
