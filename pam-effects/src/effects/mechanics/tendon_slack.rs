//! Beyond a displacement one tendon is slack.

use crate::effects::{ChamberLaw, DataScales, Effect, EffectInfo, Hooks, Point, entry};
use pam_core::Scalar;

/// The chamber of the muscle that shortens stops following x beyond ±displacement, and the restoring
/// force loses a share of its further growth.
#[derive(Debug, Clone, Copy)]
pub struct TendonSlack;

impl Effect for TendonSlack {
    fn info(&self) -> &'static EffectInfo {
        const { entry("tendon_slack") }
    }

    fn acts_where_off(&self) -> bool {
        true
    }

    fn changes_gas(&self) -> bool {
        true
    }

    fn hooks(&self) -> Hooks {
        Hooks { force: true, constants: true, ..Hooks::NONE }
    }

    fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>> {
        // With and without a stiffness that is lost: the chamber alone shows in the pressures.
        let losses = [0.25, 0.01];
        let at = |share: f64| losses.map(|loss| vec![share * scales.reach_mm, loss]);
        [0.3, 0.6, 0.85].into_iter().flat_map(at).collect()
    }

    fn stands(&self, values: &[f64], scales: &DataScales) -> bool {
        // The displacement counts from zero, wherever the joint rests.
        values[0] < scales.reach_mm * 1.2
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, _memory: &[S]) -> S {
        let x = at.displacement_mm;
        let edge = if x.real() < 0.0 { -p[0] } else { p[0] };
        if x.real().abs() <= p[0].real() {
            return S::zero();
        }
        // Only the elastic part goes slack.
        let still = S::zero();
        p[1] * (at.base.restoring_mn(x, still) - at.base.restoring_mn(edge, still))
    }

    fn chamber<S: Scalar>(&self, p: &[S], law: &mut ChamberLaw<S>) {
        law.contraction_limit_mm = Some(p[0]);
    }
}
