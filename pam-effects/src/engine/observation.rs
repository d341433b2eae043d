//! From the joint's channels on the grid to predictions at the samples, and back.

use crate::effects::{AnyEffect, EffectScalar};
use crate::simulation::integrator::Parts;
use crate::simulation::{ResampledRecord, observe};
use pam_autodiff::{Tape, Var};

/// Channels on the grid: x, ẋ, P_f, P_e.
pub(super) type Channels<S> = [Vec<S>; 4];

/// Predictions at the samples of a recording: what the sensors and the low-pass make of the channels, by
/// straight lines between grid points.
pub(super) fn shown<S: EffectScalar>(
    record: &ResampledRecord,
    parts: &Parts<'_, S>,
    channels: &mut Channels<S>,
) {
    observe(record, parts, channels);
    for (channel, low_pass) in channels.iter_mut().zip(record.filters()) {
        if let Some(low_pass) = low_pass {
            *channel = low_pass.forward_backward(channel);
        }
    }
}

/// The grid point before a time since the first sample, and the share of the way to the next one.
fn place(record: &ResampledRecord, time_s: f64) -> (usize, f64) {
    let last = record.points() - 1;
    let position = (time_s / record.step_s).clamp(0.0, last as f64);
    let k = (position as usize).min(last.saturating_sub(1));
    (k, position - k as f64)
}

/// Values at the samples from those on the grid.
pub(super) fn at_samples(
    record: &ResampledRecord,
    time_s: &[f64],
    channels: &Channels<f64>,
    out: &mut Vec<[f64; 4]>,
) {
    out.clear();
    out.extend(time_s.iter().map(|t| {
        let (k, share) = place(record, t - time_s[0]);
        std::array::from_fn(|c| {
            let values = &channels[c];
            values[k] + share * (values[(k + 1).min(values.len() - 1)] - values[k])
        })
    }));
}

/// The derivatives by the channels, and by the values of the effects (added to `by_values`), from those by the
/// predictions at the samples. `effects` come with their values.
pub(super) fn pull_back(
    (record, time_s): (&ResampledRecord, &[f64]),
    (effects, values): (&[&'static dyn AnyEffect], &[f64]),
    channels: &Channels<f64>,
    by_samples: &[[f64; 4]],
    tape: &mut Tape,
    by_values: &mut [f64],
) -> Channels<f64> {
    let points = record.points();
    let mut by: Channels<f64> = std::array::from_fn(|_| vec![0.0; points]);
    for (t, sample) in time_s.iter().zip(by_samples) {
        let (k, share) = place(record, t - time_s[0]);
        for (by, s) in by.iter_mut().zip(sample) {
            by[k] += (1.0 - share) * s;
            by[(k + 1).min(points - 1)] += share * s;
        }
    }
    for (by, low_pass) in by.iter_mut().zip(record.filters()) {
        if let Some(low_pass) = low_pass {
            *by = low_pass.transposed(by);
        }
    }
    tape.clear();
    let p = tape.variables(values);
    let leaves: Channels<Var> = std::array::from_fn(|c| tape.variables(&channels[c]));
    let seen = tape.record(|| {
        let mut seen = leaves.clone();
        observe(record, &Parts::new(effects, &p), &mut seen);
        seen
    });
    let seeds = seen.iter().flatten().copied().zip(by.iter().flatten().copied());
    let found = tape.reverse(seeds);
    found.add_to(&p, by_values);
    leaves.map(|channel| channel.into_iter().map(|var| found.of(var)).collect())
}
