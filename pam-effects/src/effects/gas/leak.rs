//! Chambers that leak.

use crate::effects::{ChamberLaw, DataScales, Effect, EffectInfo, Group, ParameterInfo};
use pam_core::Scalar;

const INFO: EffectInfo = EffectInfo {
    id: "leak",
    group: Group::Gas,
    what: "chambers that leak",
    parameters: &[
        ParameterInfo::linear("flexor_rate_per_s", [0.0, 1.0]),
        ParameterInfo::linear("extensor_rate_per_s", [0.0, 1.0]),
    ],
    switches: &[],
    air: true,
    excited_by: "a long recording at high pressure",
};

/// `ṁ_i = −rate_i · m_i (P_i − P_atm)/P_i`.
#[derive(Debug, Clone, Copy)]
pub struct Leak;

impl Effect for Leak {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn remembers(&self) -> bool {
        true
    }

    fn starts(&self, _evidence: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0, 0.0]]
    }

    fn chamber<S: Scalar>(&self, p: &[S], law: &mut ChamberLaw<S>) {
        for (rate, &more) in law.leak_per_s.iter_mut().zip(p) {
            *rate += more;
        }
    }
}
