//! Names and durations of recordings.

use crate::data::Span;
use pam_effects::simulation::Trial;

pub(super) fn spans(trials: &[&Trial]) -> Vec<Span> {
    let span =
        |t: &&Trial| Span { name: t.record.source.name.clone(), duration_s: t.record.duration_s() };
    trials.iter().map(span).collect()
}
