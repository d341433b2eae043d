//! The restoring force changes with time.

use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Point, entry};
use pam_core::Scalar;

/// Restoring force `f · (1 + relative · t / 60 s)`.
#[derive(Debug, Clone, Copy)]
pub struct StiffnessDrift;

impl Effect for StiffnessDrift {
    fn info(&self) -> &'static EffectInfo {
        const { entry("stiffness_drift") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { force: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, _memory: &[S]) -> S {
        -(p[0] * at.restoring_mn() * at.time_s).scaled(1.0 / 60.0)
    }
}
