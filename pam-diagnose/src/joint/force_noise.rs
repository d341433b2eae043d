//! Noise of the measured force, taken out where the excitation has no power.
//!
//! The force on the joint is measured with noise. A simulation that is driven by the measured force responds to the noise; the real
//! joint did not. Least squares then prefers models that respond less (errors in variables; Fuller 1987): a creep, an inertia and
//! a delay that leave the response at the excitation unchanged and attenuate every other frequency predict better than the true
//! model, on test data as well. The remedy is regression calibration (Carroll, Ruppert, Stefanski and Crainiceanu, *Measurement
//! Error in Nonlinear Models*, ch. 4): the simulation is driven by the expected value of the true force. At the frequencies of the
//! excitation that is the measured force; elsewhere it is zero, if the recordings show that the joint did not respond there.

use crate::data::OpenPart;
use crate::noise::noise_deviation;
use crate::settings::DiagnosisSettings;
use pam_core::parallel;
use pam_core::units::MN_PER_N;
use pam_data::{Channel, Recording, Subject};
use pam_effects::ExtendedModel;
use pam_effects::effects::AnyEffect;
use pam_effects::simulation::{Nuisances, Trajectory, Trial, simulate};
use pam_numerics::fourier;
use pam_numerics::statistics::{mean, mean_half_width_95, root_mean_square};

/// Trials, driven by the force to which the joint responded.
pub(super) struct Driven {
    pub(super) trials: Vec<Trial>,
    /// Root mean square of the removed part of the force, N; absent if nothing was removed.
    pub(super) noise_n: Option<f64>,
}

/// Bins of the length of a piece up to which a force counts as excitation: what is slower cannot be told from a load and, at the ends
/// of a recording, from what comes before and after it.
const SLOW_BINS: f64 = 2.0;
/// Half the width of a line under Hann's window, in bins of the length of a piece.
const LINE_BINS: f64 = 2.0;
/// Largest relative difference of the longest and the mean time between samples of a recording that has a spectrum.
const REGULAR: f64 = 0.05;

/// The frequencies at which a force has hardly any power.
struct Quiet {
    /// Whether each frequency is quiet, 0 to 1, at multiples of `bin_hz`.
    quiet: Vec<f64>,
    bin_hz: f64,
    piece_s: f64,
}

impl Quiet {
    /// The weakest frequencies that together hold at most a share of the power; `None` if there are none.
    fn of(recording: &Recording, settings: &DiagnosisSettings) -> Option<Self> {
        let force = driving_force(recording);
        let (t0, t1) = recording.span_s();
        let sample_s = (t1 - t0) / (force.len().max(2) - 1) as f64;
        let longest = recording.time_s.windows(2).map(|t| t[1] - t[0]).fold(0.0, f64::max);
        if longest > (1.0 + REGULAR) * sample_s {
            return None;
        }
        let wanted = (settings.residual.spectrum_piece_s / sample_s) as usize;
        let piece = wanted.min(force.len()).max(2);
        let power = fourier::mean_power(force, piece);
        let whole: f64 = power.iter().sum();
        if whole <= 0.0 {
            return None;
        }
        let bin_hz = 0.5 / sample_s / (power.len() - 1) as f64;
        let piece_s = piece as f64 * sample_s;
        let mut order: Vec<usize> = (0..power.len()).collect();
        order.sort_by(|&a, &b| power[a].total_cmp(&power[b]));
        let mut excited = vec![true; power.len()];
        let mut held = 0.0;
        for j in order {
            held += power[j];
            if held > settings.noise.quiet_share * whole {
                break;
            }
            excited[j] = false;
        }
        let bins = |pieces: f64| (pieces / piece_s / bin_hz).ceil() as usize;
        let (slow, reach) = (bins(SLOW_BINS), bins(LINE_BINS));
        let quiet: Vec<f64> = (0..power.len())
            .map(|j| {
                let near = j.saturating_sub(reach)..(j + reach + 1).min(power.len());
                if j <= slow || excited[near].contains(&true) { 0.0 } else { 1.0 }
            })
            .collect();
        quiet.contains(&1.0).then_some(Self { quiet, bin_hz, piece_s })
    }

    /// The quiet part of a series.
    fn part(&self, series: &[f64], step_s: f64) -> Vec<f64> {
        let reach = (self.piece_s / step_s) as usize;
        fourier::filtered(series, reach, |per_sample| {
            let at = per_sample / step_s / self.bin_hz;
            let k = (at as usize).min(self.quiet.len() - 1);
            let next = self.quiet[(k + 1).min(self.quiet.len() - 1)];
            self.quiet[k] + (at - k as f64).clamp(0.0, 1.0) * (next - self.quiet[k])
        })
    }
}

/// The force that drives the joint, mN: before its filter.
fn driving_force(recording: &Recording) -> &[f64] {
    recording.low_passed.force_mn.as_ref().unwrap_or(&recording.force_mn)
}

/// A recording without what its force has at quiet frequencies, and how these frequencies are.
fn quietened(subject: &Subject, settings: &DiagnosisSettings) -> Option<(Recording, Quiet)> {
    let quiet = Quiet::of(&subject.recording, settings)?;
    let mut recording = subject.recording.clone();
    let (t0, t1) = recording.span_s();
    let force = driving_force(&recording);
    let noise = quiet.part(force, (t1 - t0) / (force.len() - 1) as f64);
    let force = force.iter().zip(&noise).map(|(f, n)| f - n).collect();
    match &mut recording.low_passed.force_mn {
        Some(before) => *before = force,
        None => recording.force_mn = force,
    }
    Some((recording, quiet))
}

/// Trials of subjects, whose force has lost what it holds at quiet frequencies if the model predicts the open parts better without
/// it: by Student's t over blocks of time of the error at those frequencies. A fault that changes the response there by less than a
/// half does not matter.
pub(super) fn driven(
    model: &ExtendedModel,
    (trials, subjects): (Vec<Trial>, &[&Subject]),
    open: &[OpenPart],
    settings: &DiagnosisSettings,
) -> Driven {
    let quietened: Vec<_> = parallel::map(subjects.len(), |i| quietened(subjects[i], settings));
    let without: Vec<Trial> = trials
        .iter()
        .zip(&quietened)
        .map(|(t, quietened)| match quietened {
            Some((recording, _)) => t.driven_by(recording),
            None => t.clone(),
        })
        .collect();
    let of = |part: &OpenPart| {
        let e = part.experiment;
        let (_, frequencies) = quietened[e].as_ref()?;
        block_gains(model, [&trials[e], &without[e]], part.end_s, frequencies, settings)
    };
    let each: Vec<_> = parallel::map(open.len(), |k| of(&open[k]));
    let gains: Vec<f64> = each.into_iter().flatten().flatten().collect();
    let clear = mean_half_width_95(&gains).is_some_and(|half| mean(&gains) > half);
    if !clear {
        return Driven { trials, noise_n: None };
    }
    let taken = |(t, w): (&Trial, &Trial)| -> Vec<f64> {
        let forces = t.record.force.values_mn().iter().zip(w.record.force.values_mn());
        forces.map(|(a, b)| (a - b) / MN_PER_N).collect()
    };
    let taken: Vec<f64> = trials.iter().zip(&without).flat_map(taken).collect();
    Driven { noise_n: Some(root_mean_square(&taken)), trials: without }
}

/// By how much the square of what is left at quiet frequencies drops from one trial to another in each block of an open part,
/// relative to the sum of both: a few blocks in which a fault shows there as well do not count more than others. `None` if one of
/// them cannot be simulated.
fn block_gains(
    model: &ExtendedModel,
    [raw, without]: [&Trial; 2],
    end_s: f64,
    quiet: &Quiet,
    settings: &DiagnosisSettings,
) -> Option<Vec<f64>> {
    let record = &raw.record;
    let point = |time_s: f64| ((time_s / record.step_s) as usize).min(record.points());
    let end = point(end_s);
    let from = point(settings.data.burn_in_s).min(end);
    let block = (settings.intervals.block_s / record.step_s) as usize;
    let block = block.clamp(1, (end - from).max(1));
    let measured: Vec<(usize, f64)> = [Channel::X, Channel::Pf, Channel::Pe]
        .map(|c| {
            let series = vec![record.measured[c as usize][..end].to_vec()];
            (c as usize, noise_deviation(&series, settings.noise.relative))
        })
        .to_vec();
    let (effects, values): (Vec<&dyn AnyEffect>, Vec<_>) =
        model.effects.iter().map(|a| (a.effect as &dyn AnyEffect, a.values.clone())).unzip();
    let (base, values) = (model.base(), values.concat());
    let squares = |trial: &Trial| -> Option<Vec<f64>> {
        let mut out = Trajectory::default();
        simulate(trial, &base, &effects, &values, &Nuisances::none(), &mut out).ok()?;
        let mut squares = vec![0.0; (end - from) / block];
        for &(c, deviation) in &measured {
            let pairs = record.measured[c].iter().zip(&out.channels[c]).take(end);
            let residual: Vec<f64> = pairs.map(|(m, s)| m - s).collect();
            let left = quiet.part(&residual, record.step_s);
            for (sum, rows) in squares.iter_mut().zip(left[from..].chunks_exact(block)) {
                *sum += rows.iter().map(|r| (r / deviation).powi(2)).sum::<f64>();
            }
        }
        Some(squares)
    };
    let pairs = squares(raw)?.into_iter().zip(squares(without)?);
    Some(pairs.map(|(a, b)| (a - b) / (a + b).max(f64::MIN_POSITIVE)).collect())
}
