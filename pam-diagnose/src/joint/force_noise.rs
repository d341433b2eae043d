//! Noise of the measured force, where the excitation has no power.
//!
//! The force on the joint is measured with noise. A simulation that is driven by the measured force responds to the noise; the real
//! joint did not. Least squares then prefers models that respond less (errors in variables; Fuller 1987): a creep, an inertia and
//! a delay that leave the response at the excitation unchanged and attenuate every other frequency predict better than the true
//! model, on test data as well. The remedy is regression calibration (Carroll, Ruppert, Stefanski and Crainiceanu, *Measurement
//! Error in Nonlinear Models*, ch. 4): the simulation is driven by the expected value of the true force. At the frequencies of the
//! excitation that is the measured force, and elsewhere a part of it.
//!
//! That part is not known beforehand: small forces act, and noise does not. So it is an uncertain value of the system, fitted
//! along with every hypothesis through the simulation. A cause that only attenuates the response to noise has nothing left to
//! explain beside it, while a cause that holds the joint against small forces, as dry friction does, is judged by all it does.

use crate::settings::DiagnosisSettings;
use pam_core::parallel;
use pam_core::units::MN_PER_N;
use pam_data::{Recording, Subject};
use pam_effects::simulation::Trial;
use pam_numerics::fourier;
use pam_numerics::statistics::root_mean_square;

/// Half the width of a line under Hann's window, in bins of the length of a piece.
const LINE_BINS: f64 = 2.0;
/// Share of the power of a displacement at the frequencies at which the joint follows a force.
const NEARLY_ALL: f64 = 0.999;
/// Power of the noise of a force over that of its excitation, at one frequency: the ridge of the regression that separates them.
const RIDGE: f64 = 1e-6;
/// Probability that any frequency of a noise counts as one that comes and goes.
const BY_CHANCE: f64 = 0.01;
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
    /// The weakest frequencies that together hold at most a share of the power, by what it can move: a mass follows a force in
    /// proportion to the inverse square of its frequency. `None` if there are none.
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
        let pieces = fourier::power_of_pieces(force, piece);
        let bins = pieces.first().map_or(0, Vec::len);
        if bins < 2 {
            return None;
        }
        let bin_hz = 0.5 / sample_s / (bins - 1) as f64;
        let piece_s = piece as f64 * sample_s;
        let moves_below = moves_below(&recording.displacement_mm, piece);
        let power = summed(&pieces);
        let moving: Vec<f64> = (0..bins)
            .map(|j| power[j] * (moves_below as f64 / j.max(1) as f64).min(1.0).powi(4))
            .collect();
        let whole: f64 = moving.iter().sum();
        if whole <= 0.0 {
            return None;
        }
        let mut order: Vec<usize> = (0..power.len()).collect();
        order.sort_by(|&a, &b| moving[a].total_cmp(&moving[b]));
        let mut excited = vec![true; power.len()];
        let mut held = 0.0;
        for j in order {
            held += moving[j];
            if held > settings.noise.quiet_share * whole {
                break;
            }
            excited[j] = comes_and_goes(pieces.iter().map(|p| p[j]), power[j], bins);
        }
        let reach = (LINE_BINS / piece_s / bin_hz).ceil() as usize;
        let quiet: Vec<f64> = (0..power.len())
            .map(|j| {
                let near = j.saturating_sub(reach)..(j + reach + 1).min(power.len());
                if excited[near].contains(&true) { 0.0 } else { 1.0 }
            })
            .collect();
        quiet.contains(&1.0).then_some(Self { quiet, bin_hz, piece_s })
    }

    /// The part of a series at quiet frequencies.
    fn part(&self, series: &[f64], step_s: f64) -> Vec<f64> {
        let beyond = (self.piece_s / step_s) as usize;
        fourier::outside_band(series, beyond, RIDGE, |per_sample| {
            let at = per_sample / step_s / self.bin_hz;
            let k = (at as usize).min(self.quiet.len() - 1);
            let next = self.quiet[(k + 1).min(self.quiet.len() - 1)];
            let quiet = self.quiet[k] + (at - k as f64).clamp(0.0, 1.0) * (next - self.quiet[k]);
            1.0 - quiet
        })
    }
}

/// The bin below which nearly all power of a displacement is.
fn moves_below(displacement_mm: &[f64], piece: usize) -> usize {
    let power = summed(&fourier::power_of_pieces(displacement_mm, piece));
    let whole: f64 = power.iter().sum();
    let mut held = 0.0;
    let found = power.iter().position(|p| {
        held += p;
        held >= NEARLY_ALL * whole
    });
    found.unwrap_or(0).max(1)
}

/// The power of all pieces together at each frequency.
fn summed(pieces: &[Vec<f64>]) -> Vec<f64> {
    let bins = pieces.first().map_or(0, Vec::len);
    (0..bins).map(|j| pieces.iter().map(|p| p[j]).sum()).collect()
}

/// Whether the power at a frequency is concentrated in time, as in a chirp. The largest of `n` exponential variables exceeds a
/// fraction `g` of their sum with probability at most `n (1 − g)^(n − 1)` (Fisher 1929).
fn comes_and_goes(pieces: impl ExactSizeIterator<Item = f64>, sum: f64, bins: usize) -> bool {
    let n = pieces.len() as f64;
    let largest = pieces.fold(0.0, f64::max) / sum.max(f64::MIN_POSITIVE);
    n * (1.0 - largest).max(0.0).powf(n - 1.0) < BY_CHANCE / bins as f64
}

/// The force that drives the joint, mN: before its filter.
pub(super) fn driving_force(recording: &Recording) -> &[f64] {
    recording.low_passed.force_mn.as_ref().unwrap_or(&recording.force_mn)
}

/// The recording with only the quiet-frequency part of its measured force; `None` if no frequency is quiet.
fn quiet_force(subject: &Subject, settings: &DiagnosisSettings) -> Option<Recording> {
    let quiet = Quiet::of(&subject.recording, settings)?;
    let mut recording = subject.recording.clone();
    let (t0, t1) = recording.span_s();
    let force = driving_force(&recording);
    let force = quiet.part(force, (t1 - t0) / (force.len() - 1) as f64);
    match &mut recording.low_passed.force_mn {
        Some(before) => *before = force,
        None => recording.force_mn = force,
    }
    Some(recording)
}

/// For each recording a copy with the quiet-frequency part of its measured force alone; `None` if no frequency is quiet.
pub(super) fn quiet_forces(
    subjects: &[&Subject],
    settings: &DiagnosisSettings,
) -> Vec<Option<Recording>> {
    parallel::map(subjects.len(), |i| quiet_force(subjects[i], settings))
}

/// Trials that know which part of their force may be noise.
pub(super) fn with_doubtful_force(trials: Vec<Trial>, quiet: &[Option<Recording>]) -> Vec<Trial> {
    let pairs = trials.into_iter().zip(quiet);
    pairs
        .map(|(trial, quiet)| match quiet {
            Some(recording) => trial.with_doubtful_force(recording),
            None => trial,
        })
        .collect()
}

/// Root mean square of the part of the force of trials that may be noise, N; `None` if no trial has one.
pub(super) fn doubtful_force_n(trials: &[Trial]) -> Option<f64> {
    let parts = trials.iter().filter_map(|t| t.record.doubtful_force.as_ref());
    let all: Vec<f64> =
        parts.flat_map(|force| force.values_mn().iter().map(|f| f / MN_PER_N)).collect();
    (!all.is_empty()).then(|| root_mean_square(&all))
}
