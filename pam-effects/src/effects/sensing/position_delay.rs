//! The position comes late.

use super::delayed;
use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Observed, entry};
use pam_core::Scalar;

/// The displacement, and with it the velocity, is shown `delay` later.
#[derive(Debug, Clone, Copy)]
pub struct PositionDelay;

impl Effect for PositionDelay {
    fn info(&self) -> &'static EffectInfo {
        const { entry("position_delay") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { observe: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![1.0], vec![20.0]]
    }

    fn observe<S: Scalar>(&self, p: &[S], seen: &mut Observed<'_, S>) {
        let steps = p[0].scaled(1e-3 / seen.step_s);
        delayed(steps, seen.displacement_mm);
        delayed(steps, seen.velocity_mm_s);
    }
}
