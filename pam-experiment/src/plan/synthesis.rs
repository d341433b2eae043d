//! Recordings with an effect, made of baseline recordings.

use super::run::predicted;
use crate::error::ExperimentError;
use pam_data::{Channel, MassOrigin, Recording, SealedReading, Subject};
use pam_diagnose::DiagnoseOptions;
use pam_diagnose::joint::calibrated_inputs;
use pam_effects::effects::{EffectScalar, Rest};
use pam_effects::{ActiveEffect, ExtendedModel};
use pam_numerics::statistics::mean;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::f64::consts::FRAC_PI_2;

/// A block of residuals is so many correlation times long,
const CORRELATION_TIMES: f64 = 6.0;
/// at least so long (s),
const SHORTEST_S: f64 = 0.25;
/// at most this share of a recording,
const LONGEST_SHARE: f64 = 0.2;
/// and overlaps with its neighbours by this share of itself.
const OVERLAP: f64 = 0.5;
/// Autocorrelation below which lags no longer count.
const UNCORRELATED: f64 = 0.1;
/// Iterations that find the reading from which an effect's correction gives the true one.
const READINGS: usize = 30;

/// A baseline recording with what the model leaves of it.
#[derive(Debug, Clone)]
struct Baseline {
    subject: Subject,
    /// The recording with the force and the start that the model takes as true.
    calibrated: Recording,
    /// `measured − simulated` of x, ẋ, P_f, P_e, simulated along these.
    residuals: [Vec<f64>; 4],
    /// Samples of a block.
    block: usize,
}

/// Makes recordings with an effect of baseline recordings: the model is simulated with the effect under the same inputs, and
/// the residuals of the baseline are added, resampled in blocks (Künsch 1989) of several correlation times, all channels
/// together. The inputs of the simulation are without the errors of their measurement
/// ([`calibrated_inputs`]); the recordings have the measured ones, so a diagnosis meets noise of the force, its timing and a
/// noisy first sample as in the baseline, and the residuals hold nothing of them. Effects that the baseline shows
/// ([`DiagnoseOptions::discrepancy`]) are part of the model: resampled residuals do not go with the motion, these do.
///
/// Neighbouring blocks overlap with weights whose squares add up to one, so that the variance stays, and which begin and end
/// without a bend (the window of Vorbis), so that no event appears at their edges.
#[derive(Debug, Clone)]
pub struct Synthesis {
    model: ExtendedModel,
    baselines: Vec<Baseline>,
}

impl Synthesis {
    /// Simulates the baseline recordings and takes their residuals. The settings are those of a diagnosis of them.
    ///
    /// # Errors
    /// [`ExperimentError`] if the model diverges on one.
    pub fn new(
        model: &ExtendedModel,
        baseline: &[Subject],
        diagnosis: &DiagnoseOptions,
    ) -> Result<Self, ExperimentError> {
        let shown = diagnosis.discrepancy.iter().flat_map(|d| d.effects.iter().cloned());
        let model = &model.with(shown);
        let inputs = calibrated_inputs(model, baseline, diagnosis)?;
        let of = |(subject, inputs): (&Subject, Recording)| {
            let mut subject = subject.clone();
            if subject.origin != MassOrigin::GasLaw {
                subject.recording.given_masses = Some(subject.masses);
            }
            // The sealed masses are computed from the measured reading.
            let calibrated = Recording {
                given_masses: subject.recording.given_masses,
                sealed: Some(subject.recording.reading_at_rest()),
                ..inputs
            };
            let simulated = predicted(model, calibrated.clone())?;
            let residuals = Channel::ALL.map(|c| {
                let pairs = subject.recording.channel(c).iter().zip(simulated.recording.channel(c));
                pairs.map(|(m, s)| m - s).collect::<Vec<f64>>()
            });
            let block = block_samples(&subject.recording, &residuals);
            Ok(Baseline { subject, calibrated, residuals, block })
        };
        let baselines: Result<_, ExperimentError> = baseline.iter().zip(inputs).map(of).collect();
        Ok(Self { model: model.clone(), baselines: baselines? })
    }

    /// Lengths of the blocks of each recording, s.
    #[must_use]
    pub fn blocks_s(&self) -> Vec<f64> {
        let of = |b: &Baseline| {
            b.block as f64 * pam_data::recording::median_step_s(&b.subject.recording.time_s)
        };
        self.baselines.iter().map(of).collect()
    }

    /// A set of recordings with an effect, or without any. The same seed gives the same set.
    ///
    /// # Errors
    /// [`ExperimentError`] if the simulation with the effect diverges.
    pub fn set(
        &self,
        effect: Option<&ActiveEffect>,
        seed: u64,
    ) -> Result<Vec<Subject>, ExperimentError> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        self.baselines.iter().map(|b| self.one(b, effect, &mut random)).collect()
    }

    fn one(
        &self,
        baseline: &Baseline,
        effect: Option<&ActiveEffect>,
        random: &mut ChaCha8Rng,
    ) -> Result<Subject, ExperimentError> {
        let with = self.model.with(effect.cloned());
        let command = match effect {
            Some(effect) => read_with(&baseline.calibrated, effect),
            None => baseline.calibrated.clone(),
        };
        let mut made = predicted(&with, command)?;
        let noise = resampled(&baseline.residuals, baseline.block, random);
        let r = &mut made.recording;
        let columns = [
            &mut r.displacement_mm,
            &mut r.velocity_mm_s,
            &mut r.pressure_flexor_kpa,
            &mut r.pressure_extensor_kpa,
        ];
        for (column, noise) in columns.into_iter().zip(noise) {
            column.iter_mut().zip(noise).for_each(|(v, n)| *v += n);
        }
        let measured = &baseline.subject.recording;
        // The masses follow from the reading at rest, which the effect may have changed.
        let recording = Recording {
            force_mn: measured.force_mn.clone(),
            low_passed: measured.low_passed.clone(),
            preprocessing: measured.preprocessing.clone(),
            sealed: made.recording.sealed.filter(|_| measured.sealed.is_some()),
            ..made.recording
        };
        Ok(Subject::of(recording, &self.model.joint)?)
    }
}

/// A recording with the readings at rest and at the start that sensors with the effect would have shown of the same
/// joint.
fn read_with(recording: &Recording, effect: &ActiveEffect) -> Recording {
    let sealed = recording.reading_at_rest();
    let [x, _, pf, pe] = recording.initial_state();
    let truth = [
        sealed.displacement_mm,
        sealed.pressure_flexor_kpa,
        sealed.pressure_extensor_kpa,
        x,
        pf,
        pe,
    ];
    // The effect corrects readings to true values: look for those that it corrects to the known ones.
    let corrected = |seen: [f64; 6]| {
        let mut rest = Rest {
            start_s: 0.0,
            start_force_mn: recording.force_mn[0],
            sealed_mm: seen[0],
            sealed_kpa: [seen[1], seen[2]],
            start_mm: seen[3],
            start_kpa: [seen[4], seen[5]],
        };
        f64::hooks(effect.effect).rest(&effect.values, &mut rest);
        let [a, b] = rest.sealed_kpa;
        let [c, d] = rest.start_kpa;
        [rest.sealed_mm, a, b, rest.start_mm, c, d]
    };
    let mut seen = truth;
    for _ in 0..READINGS {
        let now = corrected(seen);
        for k in 0..6 {
            seen[k] += truth[k] - now[k];
        }
    }
    let mut made = recording.clone();
    if recording.sealed.is_some() {
        made.sealed = Some(SealedReading {
            displacement_mm: seen[0],
            pressure_flexor_kpa: seen[1],
            pressure_extensor_kpa: seen[2],
        });
    }
    made.displacement_mm[0] = seen[3];
    made.pressure_flexor_kpa[0] = seen[4];
    made.pressure_extensor_kpa[0] = seen[5];
    made
}

/// Samples of a block: several correlation times of the channel that is correlated longest.
fn block_samples(recording: &Recording, residuals: &[Vec<f64>; 4]) -> usize {
    let step_s = pam_data::recording::median_step_s(&recording.time_s);
    let n = recording.len();
    let longest = ((LONGEST_SHARE * n as f64) as usize).max(2);
    let correlated = |channel: &Vec<f64>| {
        let mean = mean(channel);
        let own: Vec<f64> = channel.iter().map(|v| v - mean).collect();
        let square: f64 = own.iter().map(|v| v * v).sum();
        let mut time = 1.0;
        // Lags are sampled more coarsely as they grow: a correlation is smooth in its lag.
        let mut lag = 1;
        while lag < longest && square > 0.0 {
            let pairs = own.iter().zip(&own[lag..]);
            let rho = pairs.map(|(a, b)| a * b).sum::<f64>() / square;
            if rho < UNCORRELATED {
                break;
            }
            let step = (lag / 8).max(1);
            time += 2.0 * rho * step as f64;
            lag += step;
        }
        time
    };
    let longest_correlated = residuals.iter().map(correlated).fold(1.0, f64::max);
    let wanted = (CORRELATION_TIMES * longest_correlated).max(SHORTEST_S / step_s);
    (wanted as usize).clamp(2, longest)
}

/// The weight at a part of an overlap, from 0 to 1: `faded(u)² + faded(1 − u)² = 1`, with no slope at either end.
fn faded(part: f64) -> f64 {
    (FRAC_PI_2 * (FRAC_PI_2 * part).sin().powi(2)).sin()
}

/// Residuals of all channels, resampled in overlapping blocks.
///
/// The mean is not resampled: where blocks overlap it would come back as `√2` of itself. Blocks are half to one and a half times as
/// long as given: equal ones would add a line to the spectrum.
fn resampled(residuals: &[Vec<f64>; 4], block: usize, random: &mut ChaCha8Rng) -> [Vec<f64>; 4] {
    let n = residuals[0].len();
    let overlap = ((OVERLAP * block as f64) as usize).max(1);
    let means = residuals.each_ref().map(|r| mean(r));
    let mut made = means.map(|mean| vec![mean; n]);
    let mut from = 0;
    while from < n {
        let own = random.random_range(overlap..=2 * block - overlap);
        // A block that wrapped around the end would contain a jump unless the residual is periodic.
        let source = random.random_range(0..=n.saturating_sub(own + overlap));
        for k in 0..(own + overlap).min(n - from) {
            let part = |k: usize| (k as f64 + 0.5) / overlap as f64;
            let rising = if from > 0 && k < overlap { faded(part(k)) } else { 1.0 };
            let falling = if k >= own { faded(1.0 - part(k - own)) } else { 1.0 };
            let weight = rising * falling;
            for ((to, residual), mean) in made.iter_mut().zip(residuals).zip(means) {
                to[from + k] += weight * (residual[source + k] - mean);
            }
        }
        from += own;
    }
    made
}
