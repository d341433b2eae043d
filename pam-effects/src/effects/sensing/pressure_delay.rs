//! The pressures come late.

use super::delayed;
use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Observed, entry};
use pam_core::Scalar;

/// Both pressures are shown `delay` later.
#[derive(Debug, Clone, Copy)]
pub struct PressureDelay;

impl Effect for PressureDelay {
    fn info(&self) -> &'static EffectInfo {
        const { entry("pressure_delay") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { observe: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![1.0], vec![30.0]]
    }

    fn observe<S: Scalar>(&self, p: &[S], seen: &mut Observed<'_, S>) {
        let steps = p[0].scaled(1e-3 / seen.step_s);
        for series in &mut seen.pressures_kpa {
            delayed(steps, series);
        }
    }
}
