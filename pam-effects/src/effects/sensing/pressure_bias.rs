//! The pressure sensors have an offset.

use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Observed, Rest, entry};
use pam_core::Scalar;

/// Measured pressure is the true one plus a bias; the sealed masses follow from true pressures.
#[derive(Debug, Clone, Copy)]
pub struct PressureBias;

impl Effect for PressureBias {
    fn info(&self) -> &'static EffectInfo {
        const { entry("pressure_bias") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { rest: true, observe: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
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
