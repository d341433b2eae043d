//! Names, durations and ranges of recordings, and their roles.

use super::diagnose::{DiagnoseOptions, RecordingSets};
use crate::data::{Roles, Span, TestSource, range};
use crate::error::DiagnoseError;
use pam_effects::simulation::Trial;

/// Their variables are displacement, velocity, the pressures with their sum and difference, and the force of the drive.
pub(super) fn spans(trials: &[&Trial]) -> Vec<Span> {
    let span = |t: &&Trial| {
        let record = &t.record;
        let [x, v, flexor, extensor] = &record.measured;
        let both = || flexor.iter().zip(extensor);
        Span {
            name: record.source.name.clone(),
            duration_s: record.duration_s(),
            ranges: vec![
                range(x.iter().copied()),
                range(v.iter().copied()),
                range(flexor.iter().copied()),
                range(extensor.iter().copied()),
                range(both().map(|(f, e)| f + e)),
                range(both().map(|(f, e)| f - e)),
                range((0..record.points()).map(|k| record.force_mn(k))),
            ],
        }
    };
    trials.iter().map(span).collect()
}

/// The roles of recordings and of the test set behind them, if there is one.
pub(super) fn roles(
    trials: &[&Trial],
    sets: &RecordingSets<'_>,
    options: &DiagnoseOptions,
) -> Result<Roles, DiagnoseError> {
    let source =
        if sets.test.is_some() { TestSource::GivenFrom(sets.data.len()) } else { TestSource::Kept };
    Roles::assign(&spans(trials), source, &options.settings.data)
}
