//! Dry friction that grows with the tension of the tendons.

use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Point, entry};
use pam_core::Scalar;
use pam_core::units::MN_PER_N;

/// Force `−force_n_per_kpa · (P_f + P_e)/2 · Sgn(ẋ)` with gauge pressures, set-valued at rest. The tension of a tendon is
/// proportional to the gauge pressure of its muscle, and dry friction to the load of the contact.
#[derive(Debug, Clone, Copy)]
pub struct LoadFriction;

impl Effect for LoadFriction {
    fn info(&self) -> &'static EffectInfo {
        const { entry("load_friction") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { dry_friction: true, ..Hooks::NONE }
    }

    fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>> {
        let per_kpa = scales.force_n / scales.gauge_kpa.max(1.0);
        [0.03, 0.12, 0.3].map(|share| vec![share * per_kpa]).to_vec()
    }

    fn dry_friction_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, _memory: &[S]) -> S {
        (p[0] * at.mean_gauge_kpa()).scaled(MN_PER_N)
    }
}
