//! The force comes late.

use crate::effects::{DataScales, Effect, EffectInfo, Hooks, entry};
use pam_core::Scalar;

/// Real force at t is the recorded one at `t − delay`.
#[derive(Debug, Clone, Copy)]
pub struct ActuationDelay;

impl Effect for ActuationDelay {
    fn info(&self) -> &'static EffectInfo {
        const { entry("actuation_delay") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { constants: true, delay: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![1.0], vec![20.0]]
    }

    fn delay_s<S: Scalar>(&self, p: &[S]) -> S {
        p[0].scaled(1e-3)
    }
}
