//! Dry friction that is higher near standstill.

use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Point, entry};
use pam_core::Scalar;
use pam_core::units::MN_PER_N;

/// Limit `coulomb + (static − coulomb) exp(−(ẋ/velocity)²)`, set-valued at rest (Armstrong-Hélouvry,
/// Dupont and Canudas de Wit 1994).
#[derive(Debug, Clone, Copy)]
pub struct StribeckFriction;

/// Multiple of the velocity beyond which nothing is left of the static part: `exp(−49)` is less than the rounding of what remains.
const FAST: f64 = 7.0;

impl Effect for StribeckFriction {
    fn info(&self) -> &'static EffectInfo {
        const { entry("stribeck_friction") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { dry_friction: true, ..Hooks::NONE }
    }

    fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>> {
        let force = scales.force_n;
        let speeds = [0.05, 0.3];
        let shares = [(0.04, 0.08), (0.1, 0.2)];
        shares
            .iter()
            .flat_map(|(sliding, breaking)| {
                speeds.map(|s| vec![sliding * force, breaking * force, s * scales.speed_mm_s])
            })
            .collect()
    }

    fn stands(&self, values: &[f64], scales: &DataScales) -> bool {
        // Higher near standstill by definition, and not only in the last micrometres per second.
        values[1] >= values[0] && values[2] >= 5e-4 * scales.speed_mm_s
    }

    fn dry_friction_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, _memory: &[S]) -> S {
        let ratio = at.velocity_mm_s / p[2];
        if ratio.real().abs() > FAST {
            return p[0].scaled(MN_PER_N);
        }
        (p[0] + (p[1] - p[0]) * (-(ratio * ratio)).exp()).scaled(MN_PER_N)
    }
}
