//! The encoder's zero is off.

use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Observed, Rest, entry};
use pam_core::Scalar;

/// Measured displacement is the true one plus an offset.
#[derive(Debug, Clone, Copy)]
pub struct PositionOffset;

impl Effect for PositionOffset {
    fn info(&self) -> &'static EffectInfo {
        const { entry("position_offset") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { rest: true, observe: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
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
