//! Names and durations of recordings, and their roles.

use super::diagnose::{DiagnoseOptions, RecordingSets};
use crate::data::{Roles, Span, TestSource};
use crate::error::DiagnoseError;
use pam_effects::simulation::Trial;

/// Their conditions are the sealed pressures, the sum and the difference of both.
pub(super) fn spans(trials: &[&Trial]) -> Vec<Span> {
    let span = |t: &&Trial| {
        let [flexor, extensor] = t.record.rest.sealed_kpa;
        Span {
            name: t.record.source.name.clone(),
            duration_s: t.record.duration_s(),
            conditions: vec![flexor, extensor, flexor + extensor, flexor - extensor],
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
