//! Chambers that leak.

use crate::effects::{ChamberLaw, DataScales, Effect, EffectInfo, Hooks, entry};
use pam_core::Scalar;

/// `ṁ_i = −rate_i · m_i (P_i − P_atm)/P_i`.
#[derive(Debug, Clone, Copy)]
pub struct Leak;

impl Effect for Leak {
    fn info(&self) -> &'static EffectInfo {
        const { entry("leak") }
    }

    fn changes_gas(&self) -> bool {
        true
    }

    fn remembers(&self) -> bool {
        true
    }

    fn hooks(&self) -> Hooks {
        Hooks { constants: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0, 0.0]]
    }

    fn chamber<S: Scalar>(&self, p: &[S], law: &mut ChamberLaw<S>) {
        law.leaks = true;
        for (rate, &more) in law.leak_per_s.iter_mut().zip(p) {
            *rate += more;
        }
    }
}
