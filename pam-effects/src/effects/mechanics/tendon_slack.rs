//! Beyond a displacement one tendon is slack.

use crate::effects::{ChamberLaw, DataScales, Effect, EffectInfo, Group, ParameterInfo, Point};
use pam_core::Scalar;

const INFO: EffectInfo = EffectInfo {
    id: "tendon_slack",
    group: Group::Mechanics,
    what: "one tendon is slack beyond a displacement",
    parameters: &[
        ParameterInfo::linear("displacement_mm", [0.0, 20.0]).off_at(None),
        ParameterInfo::linear("stiffness_loss", [0.0, 1.0]),
    ],
    switches: &[],
    air: true,
    excited_by: "motion beyond the slack displacement, to both sides",
};

/// The chamber of the muscle that shortens stops following x beyond ±displacement, and the restoring
/// force loses a share of its further growth.
#[derive(Debug, Clone, Copy)]
pub struct TendonSlack;

impl Effect for TendonSlack {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>> {
        let travel = scales.travel_mm;
        [0.3, 0.6, 0.85].map(|share| vec![share * travel, 0.25]).to_vec()
    }

    fn stands(&self, values: &[f64], scales: &DataScales) -> bool {
        values[0] < scales.travel_mm * 1.2
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
