//! From the joint's channels on the grid to predictions at the samples, and back.

use super::operating_model::OperatingModel;
use crate::simulation::ResampledRecord;
use crate::simulation::observation::{observe, place};
use crate::simulation::parts::Parts;
use pam_autodiff::{Tape, Var};

/// Channels on the grid: x, ẋ, P_f, P_e.
pub(super) type Channels<S> = [Vec<S>; 4];

/// Values at the samples from those on the grid.
pub(super) fn at_samples(
    record: &ResampledRecord,
    time_s: &[f64],
    channels: &Channels<f64>,
    out: &mut Vec<[f64; 4]>,
) {
    out.clear();
    out.extend(time_s.iter().map(|t| {
        let (k, share) = place(record.points(), record.step_s, t - time_s[0]);
        std::array::from_fn(|c| {
            let values = &channels[c];
            values[k] + share * (values[(k + 1).min(values.len() - 1)] - values[k])
        })
    }));
}

/// The derivatives by the channels, and by the values of the effects (added to `by_values`), from those by the
/// predictions at the samples.
pub(super) fn pull_back<T>(
    at: &OperatingModel<'_, T>,
    record: &ResampledRecord,
    time_s: &[f64],
    channels: &Channels<f64>,
    by_samples: &[[f64; 4]],
    tape: &mut Tape,
    by_values: &mut [f64],
) -> Channels<f64> {
    let points = record.points();
    let mut by: Channels<f64> = std::array::from_fn(|_| vec![0.0; points]);
    for (t, sample) in time_s.iter().zip(by_samples) {
        let (k, share) = place(record.points(), record.step_s, t - time_s[0]);
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
    let p = tape.variables(at.values);
    let leaves: Channels<Var> = std::array::from_fn(|c| tape.variables(&channels[c]));
    let seen = tape.record(|| {
        let mut seen = leaves.clone();
        observe(record, &Parts::new(at.effects, &p), &mut seen);
        seen
    });
    let seeds = seen.iter().flatten().copied().zip(by.iter().flatten().copied());
    let found = tape.reverse(seeds);
    found.add_to(&p, by_values);
    leaves.map(|channel| channel.into_iter().map(|var| found.of(var)).collect())
}
