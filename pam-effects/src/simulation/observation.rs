//! From true channels on the grid to measured ones, and to the samples of a recording.

use super::parts::Parts;
use super::record::ResampledRecord;
use crate::effects::{EffectScalar, Observed};

/// Turns true channels at the steps of the simulation into those that the sensors measure.
pub(crate) fn observe<S: EffectScalar>(
    record: &ResampledRecord,
    parts: &Parts<'_, S>,
    channels: &mut [Vec<S>; 4],
) {
    let [x, v, pf, pe] = channels;
    let mut seen = Observed {
        start_s: record.since_start_s,
        step_s: record.fine_step_s(),
        half_step_forces_mn: record.force.values_mn(),
        displacement_mm: x,
        velocity_mm_s: v,
        pressures_kpa: [pf, pe],
        before: record.before.as_deref(),
    };
    for part in &parts.list {
        part.effect.observe(part.p, &mut seen);
    }
}

/// Turns true channels at the steps of the simulation into those of the record: through the sensors, to the grid
/// points, and through the record's low-pass.
pub(crate) fn measure<S: EffectScalar>(
    record: &ResampledRecord,
    parts: &Parts<'_, S>,
    channels: &mut [Vec<S>; 4],
) {
    observe(record, parts, channels);
    if record.steps_per_point > 1 {
        for channel in channels.iter_mut() {
            *channel = channel.iter().copied().step_by(record.steps_per_point).collect();
        }
    }
    for (channel, low_pass) in channels.iter_mut().zip(record.filters()) {
        if let Some(low_pass) = low_pass {
            *channel = low_pass.forward_backward(channel);
        }
    }
}

/// The last grid point before a time (s since the first sample) that has a successor, and the share of the way
/// to that.
pub(crate) fn place(points: usize, step_s: f64, time_s: f64) -> (usize, f64) {
    let last = points.saturating_sub(1);
    let position = (time_s / step_s).clamp(0.0, last as f64);
    let k = (position as usize).min(last.saturating_sub(1));
    (k, position - k as f64)
}
