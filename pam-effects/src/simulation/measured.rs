//! The measured start of a recording.

use super::record::ResampledRecord;
use crate::effects::{EffectScalar, Rest};

/// Readings at rest and at the start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Measured<S> {
    pub(crate) rest: Rest<S>,
    /// Velocity at the first sample, mm/s.
    pub(crate) start_mm_s: S,
}

impl<S: EffectScalar> Measured<S> {
    /// The readings of a recording.
    pub(crate) fn of(record: &ResampledRecord) -> Self {
        let c = S::constant;
        let rest = Rest {
            start_s: record.since_start_s,
            start_force_mn: record.rest.start_force_mn,
            sealed_mm: c(record.rest.sealed_mm),
            sealed_kpa: record.rest.sealed_kpa.map(c),
            start_mm: c(record.rest.start_mm),
            start_kpa: record.rest.start_kpa.map(c),
        };
        Self { rest, start_mm_s: c(record.start_velocity.mm_s) }
    }
}
