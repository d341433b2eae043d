//! The position sensor is off by a factor.

use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Observed, Rest, entry};
use pam_core::Scalar;

/// Measured displacement is `(1 + relative)` times the true one.
#[derive(Debug, Clone, Copy)]
pub struct PositionGain;

impl Effect for PositionGain {
    fn info(&self) -> &'static EffectInfo {
        const { entry("position_gain") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { rest: true, observe: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn rest<S: Scalar>(&self, p: &[S], rest: &mut Rest<S>) {
        let gain = p[0] + S::constant(1.0);
        rest.sealed_mm /= gain;
        rest.start_mm /= gain;
    }

    fn observe<S: Scalar>(&self, p: &[S], seen: &mut Observed<'_, S>) {
        let gain = p[0] + S::constant(1.0);
        for value in seen.displacement_mm.iter_mut().chain(seen.velocity_mm_s.iter_mut()) {
            *value *= gain;
        }
    }
}
