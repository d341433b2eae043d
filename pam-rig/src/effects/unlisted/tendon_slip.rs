//! A tendon that slips on the pulley at one moment.

use crate::effects::{Clock, EffectInfo, Group, HiddenEffect, ParameterInfo, Phenomenon, Seen};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: &EffectInfo::new(
        "tendon_slip",
        Group::Mechanics,
        "tendon that slips on the pulley, which moves the encoder's zero",
        &[
            ParameterInfo::linear("time_s", [0.0, 1e5]).off_at(None).meaning("time of the slip"),
            ParameterInfo::linear("slip_mm", [-20.0, 20.0])
                .meaning("from then on measured − true displacement"),
        ],
    ),
    typical: &[31.0, 0.4],
    build: |v| Box::new(TendonSlip { time_s: v[0], slip_mm: v[1] }),
};

struct TendonSlip {
    time_s: f64,
    slip_mm: f64,
}

impl Phenomenon for TendonSlip {
    fn observe(&mut self, clock: &Clock, seen: &mut Seen) {
        if clock.time_s >= self.time_s {
            seen.displacement_mm += self.slip_mm;
        }
    }
}
