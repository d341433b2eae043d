//! An encoder that stops counting now and then.

use crate::effects::{Clock, EffectInfo, Group, HiddenEffect, ParameterInfo, Phenomenon, Seen};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: &EffectInfo::new(
        "encoder_freeze",
        Group::Sensing,
        "encoder that repeats its last value now and then",
        &[
            ParameterInfo::scale("period_s", [1e-2, 1e5]).meaning("time between two freezes"),
            ParameterInfo::linear("duration_s", [0.0, 1e5]).meaning("length of a freeze"),
        ],
    ),
    typical: &[7.3, 0.3],
    build: |v| Box::new(EncoderFreeze { period_s: v[0], duration_s: v[1], held_mm: 0.0 }),
};

struct EncoderFreeze {
    period_s: f64,
    duration_s: f64,
    held_mm: f64,
}

impl Phenomenon for EncoderFreeze {
    fn observe(&mut self, clock: &Clock, seen: &mut Seen) {
        // The first freeze comes after a full period.
        let frozen =
            clock.time_s >= self.period_s && clock.time_s % self.period_s < self.duration_s;
        if frozen {
            seen.displacement_mm = self.held_mm;
        } else {
            self.held_mm = seen.displacement_mm;
        }
    }
}
