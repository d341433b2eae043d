//! What a protocol is worth.

use super::space::DesignLimits;
use crate::detect::{Demand, Kind, Ray, of_nothing, signature, span_of};
use crate::error::ExperimentError;
use crate::plan::{SensorView, planned_runs, sensor_view};
use pam_data::Subject;
use pam_diagnose::DiagnoseOptions;
use pam_diagnose::joint::{PreparedTrials, Signature, SignatureSpan, Signatures};
use pam_diagnose::noise::Noise;
use pam_effects::ExtendedModel;
use pam_effects::effects::AnyEffect;
use pam_numerics::statistics::median;
use pam_rig::Protocol;
use pam_rig::sensors::SensorParameters;
use statrs::distribution::{ContinuousCDF, Normal};

/// What a design is to improve.
#[derive(Debug, Clone, PartialEq)]
pub enum Objective {
    /// The median of the logarithms of the detection limits.
    MedianLimit,
    /// The worst of them.
    WorstLimit,
    /// The distance between live causes and what may be taken for them.
    Separation(Vec<LiveCause>),
}

/// A cause that may be at work, with others that may be taken for it: places of candidates and their values.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveCause {
    /// The cause.
    pub cause: (usize, Vec<f64>),
    /// The others.
    pub others: Vec<(usize, Vec<f64>)>,
}

impl Objective {
    /// Checks that every live cause is a candidate with all of its values.
    pub(super) fn check(
        &self,
        candidates: &[&'static dyn AnyEffect],
    ) -> Result<(), ExperimentError> {
        let Self::Separation(live) = self else { return Ok(()) };
        let places = live.iter().flat_map(|l| std::iter::once(&l.cause).chain(&l.others));
        for (place, values) in places {
            let Some(info) = candidates.get(*place).map(|c| c.info()) else {
                let count = candidates.len();
                let message = format!("there are {count} candidates");
                return Err(ExperimentError::setting(format!("live cause {place}"), message));
            };
            if values.len() != info.value_len() {
                let names: Vec<&str> = info.value_names().collect();
                let message =
                    format!("it has the values {}, not {}", names.join(", "), values.len());
                return Err(ExperimentError::setting(format!("live cause `{}`", info.id), message));
            }
        }
        Ok(())
    }
}

/// Share of the mean in a median, so that an effect away from the middle counts as well.
const MEAN_SHARE: f64 = 0.1;
/// Least excess that counts.
const LEAST: f64 = 1e-6;

/// Everything by which proposals are judged.
pub(super) struct Judge<'a> {
    pub(super) model: &'a ExtendedModel,
    pub(super) options: &'a DiagnoseOptions,
    pub(super) sensors: &'a SensorParameters,
    /// The noise model for all protocols. If `None`, each protocol gets the noise of its simulated sensors.
    pub(super) noise: Option<&'a Noise>,
    pub(super) objective: &'a Objective,
    /// Effects with the magnitudes at which they are compared.
    pub(super) ways: Vec<(Ray, f64)>,
    pub(super) limits: &'a DesignLimits,
    pub(super) seed: u64,
}

impl Judge<'_> {
    /// The simulated recordings of a protocol; `None` if the joint leaves the range of the model.
    pub(super) fn simulated(&self, protocol: &Protocol) -> Option<Vec<Subject>> {
        let rate_hz = self.sensors.clock.rate_hz;
        let runs = planned_runs(protocol, &self.sensors.motor, rate_hz, self.seed).ok()?;
        let subject = |run: &crate::plan::PlannedRun| {
            let subject = run.simulated(self.model).ok()?;
            let within = |values: &[f64], most: f64| values.iter().all(|v| v.abs() <= most);
            let r = &subject.recording;
            let inside = within(&r.displacement_mm, self.limits.travel_mm)
                && within(&r.velocity_mm_s, self.limits.speed_mm_s);
            inside.then_some(subject)
        };
        runs.iter().map(subject).collect()
    }

    /// The worth of a protocol, a logarithm; minus infinity if it cannot be run.
    pub(super) fn worth(&self, protocol: &Protocol) -> f64 {
        self.simulated(protocol)
            .and_then(|recordings| self.of_recordings(&recordings).ok())
            .unwrap_or(f64::NEG_INFINITY)
    }

    /// The sensor noise of simulated recordings, and the recordings as the sensors would measure them.
    pub(super) fn view(&self, recordings: &[Subject]) -> Result<SensorView, ExperimentError> {
        match self.noise {
            Some(noise) => Ok(noise.clone().into()),
            None => sensor_view(self.model, recordings, self.sensors, self.options),
        }
    }

    fn of_recordings(&self, recordings: &[Subject]) -> Result<f64, ExperimentError> {
        let noise = self.view(recordings)?.noise;
        let trials = PreparedTrials::new(self.model, recordings, &self.options.settings)?;
        let signatures = Signatures::of_all(self.model, &trials, self.options, Some(&noise))?;
        Ok(match self.objective {
            Objective::Separation(live) => {
                let all = live
                    .iter()
                    .flat_map(|cause| separations(&signatures, &self.options.candidates, cause));
                all.map(|d| d.max(LEAST).ln()).fold(f64::INFINITY, f64::min)
            }
            objective => {
                let gain = |(ray, magnitude): &(Ray, f64)| {
                    let demand = Demand {
                        signatures: &signatures,
                        // They take as long as everything else and seldom decide.
                        directions: &[],
                        seed: self.seed,
                        parameters: ray.parameters,
                        power: 0.9,
                        level: 0.05,
                        apparent: &[],
                    };
                    let nothing = of_nothing(&signatures, ray);
                    let s = signature(&signatures, ray, *magnitude, nothing.as_ref());
                    let excess = s.map_or(0.0, |s| demand.excess(Kind::Named, &s));
                    0.5 * excess.max(LEAST).ln()
                };
                let gains: Vec<f64> = self.ways.iter().map(gain).collect();
                if *objective == Objective::WorstLimit {
                    gains.into_iter().fold(f64::INFINITY, f64::min)
                } else {
                    let mean = gains.iter().sum::<f64>() / gains.len().max(1) as f64;
                    median(&gains) + MEAN_SHARE * mean
                }
            }
        })
    }
}

/// Factors by which the parameters of a cause are tried to imitate another one.
const FACTORS: [f64; 6] = [0.125, 0.25, 0.5, 2.0, 4.0, 8.0];

/// The values of an effect, near the given ones, at which it imitates a signature best: one parameter after the other is scaled, or
/// its distance from the value at which the effect is absent.
fn imitating(
    signatures: &Signatures<'_>,
    s: &Signature,
    (candidate, effect): (usize, &dyn AnyEffect),
    values: &[f64],
) -> Vec<f64> {
    let left = |values: &[f64]| {
        let own = signatures.of(candidate, values)?;
        Some(s.beside(&SignatureSpan::of(&[own])).square())
    };
    let mut best = values.to_vec();
    let Some(mut least) = left(&best) else { return best };
    for (k, p) in effect.info().parameters.iter().enumerate() {
        let off = p.off.filter(|_| !p.logarithmic).unwrap_or(0.0);
        let start = best.clone();
        for factor in FACTORS {
            let mut tried = start.clone();
            tried[k] = (off + factor * (start[k] - off)).clamp(p.range[0], p.range[1]);
            if let Some(own) = left(&tried).filter(|own| *own < least) {
                (least, best) = (own, tried);
            }
        }
    }
    best
}

/// Power with which live causes are to be distinguished.
const POWER: f64 = 0.9;

/// How far a cause is from the span of each of the others, over what a diagnosis needs to distinguish them with 90 % power:
/// the lesser of the distance (the root of the drop that is left when the other is fitted in its place) over the one at which
/// the odds are enough, and of the root of the share that the other cannot remove over the least one.
pub(super) fn separations(
    signatures: &Signatures<'_>,
    candidates: &[&'static dyn AnyEffect],
    live: &LiveCause,
) -> Vec<f64> {
    let (candidate, values) = &live.cause;
    let Some(s) = signatures.of(*candidate, values) else { return vec![0.0; live.others.len()] };
    let a = signatures.acceptance();
    let z = Normal::standard().inverse_cdf(POWER);
    let needed = z + (z * z + 2.0 * a.rows_per_observation * a.confusable_odds.ln()).sqrt();
    let size = s.square().max(f64::MIN_POSITIVE);
    let ratio = |(other, values): &(usize, Vec<f64>)| {
        let values = imitating(signatures, &s, (*other, candidates[*other]), values);
        let span = SignatureSpan::of(&span_of(signatures, *other, &values));
        let left = s.beside(&span).square();
        (left.sqrt() / needed).min((left / size / (1.0 - a.confusable_share)).sqrt())
    };
    live.others.iter().map(ratio).collect()
}
