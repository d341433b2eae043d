//! Play between joint and encoder.

use crate::effects::{Clock, HiddenEffect, Phenomenon, Seen, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("backlash"),
    typical: &[0.2],
    build: |v| Box::new(Backlash { gap_mm: v[0], encoder_mm: None }),
};

/// The play operator: the encoder is pushed by the ends of the gap and rests between.
struct Backlash {
    gap_mm: f64,
    encoder_mm: Option<f64>,
}

impl Phenomenon for Backlash {
    fn observe(&mut self, _clock: &Clock, seen: &mut Seen) {
        let x = seen.displacement_mm;
        let half = 0.5 * self.gap_mm;
        let encoder = self.encoder_mm.get_or_insert(x);
        *encoder = encoder.clamp(x - half, x + half);
        seen.displacement_mm = *encoder;
    }
}
