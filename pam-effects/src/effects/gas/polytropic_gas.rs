//! Pressure with another exponent of the volume.

use crate::effects::{ChamberLaw, DataScales, Effect, EffectInfo, Hooks, entry};
use pam_core::Scalar;

/// `P Vⁿ` constant, with or without the force of the changed pressure on the joint.
#[derive(Debug, Clone, Copy)]
pub struct PolytropicGas;

impl Effect for PolytropicGas {
    fn info(&self) -> &'static EffectInfo {
        const { entry("polytropic_gas") }
    }

    fn changes_gas(&self) -> bool {
        true
    }

    fn hooks(&self) -> Hooks {
        Hooks { constants: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![1.0, 0.0], vec![1.0, 1.0]]
    }

    fn chamber<S: Scalar>(&self, p: &[S], law: &mut ChamberLaw<S>) {
        law.exponent *= p[0];
        law.feeds_back |= p[1].real() > 0.5;
    }
}
