//! Which reading of the columns each recording gets, and how sure that is.

use super::finding::Severity;
use super::sample::Sample;
use super::weigh::{Reading, Weights};
use pam_core::{ForceModel, parallel};

/// The reading of one recording's columns and the log odds behind it.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChosenReading {
    pub(super) reading: Reading,
    /// Log odds of the pressures' unit, the displacement's unit and the direction against the stated ones.
    pub(super) odds: [f64; 3],
}

/// The most credible reading of each recording. Recordings of one set were exported together, so that a reading is sought
/// for all first, then for those that contradict it alone.
pub(super) fn readings<F: ForceModel<f64> + Sync>(
    weights: &Weights<'_, F>,
    samples: &[Sample<'_>],
) -> Vec<ChosenReading> {
    let s = weights.settings;
    let shared = |set: &[&Sample<'_>]| {
        let (best, odds) = weights.best(set);
        if odds >= s.warning_log_odds { best } else { Reading::STATED }
    };
    let own = |sample: &Sample<'_>, common: Reading| {
        let one = [sample];
        let (own, _) = weights.best(&one);
        // Gauge or absolute is a question of the whole set, unless a recording is impossible by itself.
        let gauge_only = weights.units[own.pressure].is_gauge_kpa()
            && own == Reading { pressure: own.pressure, ..common }
            && sample.pressures.iter().all(|p| *p >= s.lowest_kpa);
        let odds = weights.score(&one, own) - weights.score(&one, common);
        (odds >= s.error_log_odds && !gauge_only && samples.len() > 1).then_some(own)
    };
    let all: Vec<&Sample<'_>> = samples.iter().collect();
    let first = shared(&all);
    let others: Vec<Option<Reading>> = parallel::map(samples.len(), |i| own(&samples[i], first));
    // Those that contradict the rest say nothing about it.
    let rest: Vec<&Sample<'_>> = samples
        .iter()
        .zip(&others)
        .filter(|(_, o)| o.is_none())
        .map(|(sample, _)| sample)
        .collect();
    let rest = if rest.is_empty() { &all } else { &rest };
    let common = shared(rest);
    let together = components(weights, rest, common);
    samples
        .iter()
        .zip(others)
        .map(|(sample, other)| match other {
            Some(reading) => {
                ChosenReading { reading, odds: components(weights, &[sample], reading) }
            }
            None => ChosenReading { reading: common, odds: together },
        })
        .collect()
}

/// Log odds of each component of a reading against the stated one, the others kept.
fn components<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    samples: &[&Sample<'_>],
    reading: Reading,
) -> [f64; 3] {
    let score = weights.score(samples, reading);
    let others = [
        Reading { pressure: 0, ..reading },
        Reading { displacement: 0, ..reading },
        Reading { reversed: false, ..reading },
    ];
    others.map(|other| if other == reading { 0.0 } else { score - weights.score(samples, other) })
}

/// The severity of these log odds, if they are reported.
pub(super) fn severity<F>(weights: &Weights<'_, F>, odds: f64) -> Option<Severity> {
    let s = weights.settings;
    if odds >= s.error_log_odds {
        Some(Severity::Error)
    } else {
        (odds >= s.warning_log_odds).then_some(Severity::Warning)
    }
}

/// The severity of the direction of a chosen reading.
pub(super) fn direction<F>(weights: &Weights<'_, F>, chosen: &ChosenReading) -> Option<Severity> {
    severity(weights, chosen.odds[2])
}
