//! A tendon that slips on the pulley at one moment.

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon, Seen};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "tendon_slip",
    group: Group::Unlisted,
    what: "at time_s the tendon slips on the pulley, and the encoder's zero moves by slip_mm",
    parameters: &[
        ParameterInfo::new("time_s", 31.0, [0.0, 1e5]),
        ParameterInfo::new("slip_mm", 0.4, [-20.0, 20.0]),
    ],
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
