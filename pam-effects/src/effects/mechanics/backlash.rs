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
        let mut before = encoder;
        for k in 0..seen.displacement_mm.len() {
            let x = seen.displacement_mm[k];
            if let Some(turn) = turning_point(before, seen, k) {
                encoder = encoder.clamped(turn - half, turn + half);
            }
            encoder = encoder.clamped(x - half, x + half);
            seen.displacement_mm[k] = encoder;
            before = x;
        }
        seen.renew_velocity();
    }
}

/// Where the motion turns between the value `before` and value `k` with constant acceleration, `x + v₀² h / (2 (v₀ − v₁))`; `None` if it does
/// not turn. The encoder keeps the extreme, which the values themselves miss.
fn turning_point<S: Scalar>(before: S, seen: &Observed<'_, S>, k: usize) -> Option<S> {
    let (from, to) = (seen.velocity_mm_s[k.checked_sub(1)?], seen.velocity_mm_s[k]);
    let turns = from.real() * to.real() < 0.0;
    turns.then(|| before + (from * from / (from - to)).scaled(0.5 * seen.step_s))
}
