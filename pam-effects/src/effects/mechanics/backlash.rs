//! Play between joint and encoder.

use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Observed, entry};
use pam_core::Scalar;

/// The play operator: the encoder is pushed by the ends of the gap and rests between.
#[derive(Debug, Clone, Copy)]
pub struct Backlash;

impl Effect for Backlash {
    fn info(&self) -> &'static EffectInfo {
        const { entry("backlash") }
    }

    fn remembers(&self) -> bool {
        true
    }

    fn hooks(&self) -> Hooks {
        Hooks { observe: true, ..Hooks::NONE }
    }

    fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>> {
        [0.02, 0.1, 0.4].map(|share| vec![share * scales.travel_mm]).to_vec()
    }

    fn observe<S: Scalar>(&self, p: &[S], seen: &mut Observed<'_, S>) {
        let half = p[0].scaled(0.5);
        // The encoder's place in the play is not known at the start; the middle loses least.
        let mut encoder = seen.displacement_mm[0];
        for x in seen.displacement_mm.iter_mut() {
            encoder = encoder.clamped(*x - half, *x + half);
            *x = encoder;
        }
        seen.renew_velocity();
    }
}
