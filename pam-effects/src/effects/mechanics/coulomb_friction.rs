//! Dry friction with sticking.

use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Point, entry};
use pam_core::Scalar;
use pam_core::units::MN_PER_N;

/// Force `−force_n · Sgn(ẋ)`, set-valued at rest.
#[derive(Debug, Clone, Copy)]
pub struct CoulombFriction;

impl Effect for CoulombFriction {
    fn info(&self) -> &'static EffectInfo {
        const { entry("coulomb_friction") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { dry_friction: true, ..Hooks::NONE }
    }

    fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>> {
        [0.03, 0.12, 0.3].map(|share| vec![share * scales.force_n]).to_vec()
    }

    fn dry_friction_mn<S: Scalar>(&self, p: &[S], _at: &Point<'_, S>, _memory: &[S]) -> S {
        p[0].scaled(MN_PER_N)
    }
}
