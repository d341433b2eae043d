//! An encoder that stops counting now and then.

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon, Seen};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "encoder_freeze",
    group: Group::Unlisted,
    what: "every period_s the encoder repeats its last value for duration_s",
    parameters: &[
        ParameterInfo::new("period_s", 7.3, [1e-2, 1e5]),
        ParameterInfo::new("duration_s", 0.3, [0.0, 1e5]),
    ],
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
