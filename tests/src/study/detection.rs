//! Size of what is hidden, relative to the limit of detection in the data of a case.
//!
//! The size of a fault is the root of the deviance that it adds: over the channels x, P_f, P_e, the mean square of the
//! residual that it leaves to a model without it, over the variance of that mean under noise,
//!
//! `S² = Σ_c E_c / (σ_c²/N_c + g_c² σ_F²/N_F + D_c²/R)`
//!
//! with the noise `σ_c` of the channel and its effective number of samples `N_c`, the noise of the recorded force, which
//! moves the prediction, and the discrepancy `D_c` of the model, one value for each of `R` recordings. Only the part of
//! the residual counts that [nuisance parameters](super::nuisances) do not explain: mass, deformation coefficient and time of the force, and
//! the sealed masses and pressure offsets of each recording. A fault is detectable from [`LIMIT`] on.
//!
//! Beside other faults a fault has a second size, [`Scale::size_beside`]: what is left of it after the others, at whatever
//! values, have taken as much of its residual as they can, to first order.

use super::case::{Case, Strength};
use super::nuisances::{Basis, LEAD_SAMPLES, MODEL, OFFSET_KPA, SEALED_MASS, norm};
use crate::magnitudes::{self, Motion};
use crate::plant::{Excitation, Experiment, Hidden, Noise, Plant, Sensors};
use pam_data::Recording;

/// Size from which a fault counts as detectable. A candidate with one parameter among 28 needs χ² = 9.8 for a familywise error
/// rate of 5 % (Bonferroni), a power of 95 % adds 1.64 standard deviations: `(3.1 + 1.64)² = 22.5`, and alternatives that
/// take up a part of the residual take it to 36.
pub const LIMIT: f64 = 6.0;

/// Size of medium strength, relative to the limit, where the usual magnitude is smaller; of weak strength.
const MEDIUM_LIMITS: f64 = 3.0;
const WEAK_LIMITS: f64 = 1.5;

/// Largest factor on the usual magnitude; factor of strong on medium; most of weak.
const LARGEST_FACTOR: f64 = 3.0;
const STRONG_FACTOR: f64 = 2.0;
const WEAK_FACTOR: f64 = 0.5;
const SMALLEST_FACTOR: f64 = 0.02;

/// The published joint at 45 psi: stiffness (N/mm), noise bandwidth `ω₀/(8 ζ)` of its response (Hz), and change of either
/// pressure with x (kPa/mm).
const STIFFNESS_N_MM: f64 = 150.0;
const RESPONSE_HZ: f64 = 6.3;
const KPA_PER_MM: f64 = 13.0;

/// Sampling rate of residuals, well above the bandwidth of the joint.
const RESIDUAL_HZ: f64 = 100.0;

/// Relative change of a nuisance parameter for finite differences.
const DIFFERENCE: f64 = 0.01;

/// Longest integration step, s; sizes need less accuracy than the recordings of a case.
const LONGEST_STEP_S: f64 = 1e-3;

/// Correlation of the noise below which lags no longer count.
const UNCORRELATED: f64 = 0.05;

const KPA_PER_PSI: f64 = 6.894_76;
const ATMOSPHERE_KPA: f64 = 101.325;

/// What sizes of faults are measured against, for one case.
#[derive(Debug)]
pub struct Scale<'a> {
    case: &'a Case,
    plant: &'a Plant,
    conditions: &'a [[f64; 2]],
    sensors: Sensors,
    quiet: Sensors,
    /// Variance of the mean of the residual of x, P_f, P_e.
    variance: [f64; 3],
    /// The changes that nuisance parameters explain.
    nuisances: Basis,
    /// Motion without faults.
    pub motion: Motion,
}

fn channels(r: &Recording) -> [&[f64]; 3] {
    [&r.displacement_mm, &r.pressure_flexor_kpa, &r.pressure_extensor_kpa]
}

fn mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len().max(1) as f64;
    values.map(|v| v * v).sum::<f64>() / n
}

/// Effective number of independent samples: length over integrated autocorrelation time.
fn effective(values: &[f64]) -> f64 {
    let n = values.len();
    let variance = mean_square(values.iter().copied()).max(f64::MIN_POSITIVE);
    let correlation = |lag: usize| {
        let pairs = values.iter().zip(&values[lag..]);
        pairs.map(|(a, b)| a * b).sum::<f64>() / (n - lag) as f64 / variance
    };
    let mut time = 1.0;
    for lag in 1..n / 4 {
        let rho = correlation(lag);
        if rho < UNCORRELATED {
            break;
        }
        time += 2.0 * rho;
    }
    n as f64 / time
}

impl<'a> Scale<'a> {
    /// Measures noise, discrepancy of `model` and motion on the recordings of a case.
    #[must_use]
    pub fn of(case: &'a Case, plant: &'a Plant, model: &Plant, conditions: &'a [[f64; 2]]) -> Self {
        let sensors = case.factors.sensors();
        let none = Noise::white(0.0);
        let quiet =
            Sensors { encoder_mm: 0.0, displacement: none, pressure: none, force: none, ..sensors };
        let mut scale = Self {
            case,
            plant,
            conditions,
            sensors,
            quiet,
            variance: [0.0; 3],
            nuisances: Basis::default(),
            motion: Motion { force_n: 0.0, travel_mm: 0.0 },
        };
        // One recording shows the noise; the motion and the discrepancy are those of all.
        let clean: Vec<Recording> = (conditions.iter().enumerate())
            .map(|(i, &psi)| scale.record(plant, i, psi, &[], &quiet))
            .collect();
        let noisy = scale.record(plant, 0, conditions[0], &[], &sensors);
        let recordings = conditions.len() as f64;
        let step_s = 1.0 / sensors.rate_hz;
        let rho = force_correlation(sensors.force, step_s);
        let force_share = (2.0 * RESPONSE_HZ * step_s * (1.0 + rho) / (1.0 - rho)).min(1.0);
        let force_mm = sensors.force.deviation * force_share.sqrt() / STIFFNESS_N_MM;
        let force_samples = 2.0 * RESPONSE_HZ * case.factors.duration_s * recordings;
        for c in 0..3 {
            let pairs = channels(&noisy)[c].iter().zip(channels(&clean[0])[c]);
            let noise: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
            let own = mean_square(noise.iter().copied()) / (recordings * effective(&noise));
            let moved = force_mm * if c == 0 { 1.0 } else { KPA_PER_MM };
            scale.variance[c] = own + moved * moved / force_samples;
        }
        let mut discrepancy = [0.0; 3];
        for (i, truth) in clean.iter().enumerate() {
            let seen = scale.predicted(model, i, truth);
            for (c, sum) in discrepancy.iter_mut().enumerate() {
                let apart = channels(truth)[c].iter().zip(channels(&seen)[c]);
                *sum += mean_square(apart.map(|(a, b)| a - b)) / recordings;
            }
            let x = &truth.displacement_mm;
            let middle = x.iter().sum::<f64>() / x.len() as f64;
            let force = truth.low_passed.force_mn.as_ref().unwrap_or(&truth.force_mn);
            let largest = |values: &[f64], middle: f64| {
                values.iter().map(|v| (v - middle).abs()).fold(0.0, f64::max)
            };
            scale.motion.travel_mm = scale.motion.travel_mm.max(largest(x, middle));
            scale.motion.force_n = scale.motion.force_n.max(1e-3 * largest(force, 0.0));
        }
        for (variance, discrepancy) in scale.variance.iter_mut().zip(discrepancy) {
            *variance += discrepancy / recordings;
        }
        scale.nuisances = Basis::of_nuisances(scale.nuisance_changes(&clean));
        scale
    }

    /// The changes of the residual by one standard deviation of each nuisance parameter, from the recordings without faults.
    fn nuisance_changes(&self, clean: &[Recording]) -> Vec<Vec<f64>> {
        let difference = |plant: &Plant, i: usize, psi, factor: f64| {
            let changed = self.record(plant, i, psi, &[], &self.quiet);
            self.weighted_difference(&changed, &clean[i], factor / DIFFERENCE)
        };
        let of_plant = |changed: Plant| -> Vec<f64> {
            let all = self.conditions.iter().enumerate();
            all.flat_map(|(i, &psi)| difference(&changed, i, psi, MODEL)).collect()
        };
        let mut changes = vec![
            of_plant(self.plant.with_mass(1.0 + DIFFERENCE)),
            of_plant(self.plant.with_deformation(1.0 + DIFFERENCE)),
            clean.iter().flat_map(|recording| self.weighted_shift(recording)).collect(),
        ];
        // The recordings of a case have equal lengths.
        let of_recording = |i: usize, own: Vec<f64>| {
            let mut all = vec![0.0; clean.len() * own.len()];
            all[i * own.len()..(i + 1) * own.len()].copy_from_slice(&own);
            all
        };
        // The first sample of a pressure carries its noise.
        let offset_kpa = OFFSET_KPA.hypot(self.sensors.pressure.deviation);
        for (i, recording) in clean.iter().enumerate() {
            for side in 0..2 {
                let mut psi = self.conditions[i];
                let kpa = ATMOSPHERE_KPA + KPA_PER_PSI * psi[side];
                psi[side] += DIFFERENCE * kpa / KPA_PER_PSI;
                let mass = SEALED_MASS.hypot(self.sealed_noise_kpa() / kpa);
                changes.push(of_recording(i, difference(self.plant, i, psi, mass)));
                let offset = |c: usize, _| if c == 1 + side { offset_kpa } else { 0.0 };
                changes.push(of_recording(i, self.weighted(recording, offset)));
            }
        }
        changes
    }

    /// Standard deviation of the pressures of the sealed reading, kPa: a mean over the rest before the excitation.
    fn sealed_noise_kpa(&self) -> f64 {
        let noise = self.sensors.pressure;
        let rho = noise.colour.correlation(1.0 / self.sensors.rate_hz);
        let samples = Plant::rest_samples(self.sensors.rate_hz) as f64;
        let independent = (samples * (1.0 - rho) / (1.0 + rho)).max(1.0);
        noise.deviation / independent.sqrt()
    }

    /// Changes of the samples of a recording by channel and sample, at the rate of residuals and weighted so that their norm is their size.
    fn weighted(&self, recording: &Recording, change: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        let every = (self.sensors.rate_hz / RESIDUAL_HZ).round().max(1.0) as usize;
        let samples: Vec<usize> = (0..recording.displacement_mm.len()).step_by(every).collect();
        let values = (self.conditions.len() * samples.len()) as f64;
        let of_channel = |c: usize| {
            let unit = (self.variance[c].max(f64::MIN_POSITIVE) * values).sqrt();
            samples.iter().map(|&k| change(c, k) / unit).collect::<Vec<_>>()
        };
        (0..3).flat_map(of_channel).collect()
    }

    /// The difference of two recordings, times a factor.
    fn weighted_difference(&self, after: &Recording, before: &Recording, factor: f64) -> Vec<f64> {
        let [after, values] = [after, before].map(channels);
        self.weighted(before, |c, k| factor * (after[c][k] - values[c][k]))
    }

    /// The change of a recording by a shift in time of [`LEAD_SAMPLES`].
    fn weighted_shift(&self, recording: &Recording) -> Vec<f64> {
        let values = channels(recording);
        let last = recording.displacement_mm.len() - 1;
        self.weighted(recording, |c, k| {
            let (from, to) = (k.saturating_sub(1), (k + 1).min(last));
            LEAD_SAMPLES * (values[c][to] - values[c][from]) / (to - from) as f64
        })
    }

    fn record(
        &self,
        plant: &Plant,
        i: usize,
        psi: [f64; 2],
        effects: &[Hidden],
        sensors: &Sensors,
    ) -> Recording {
        let excitation: Excitation = self.case.factors.excitation(i, self.case.seed);
        let acting: Vec<Hidden> = effects.iter().filter(|e| e.acts_in(i)).cloned().collect();
        let run = Experiment::new("size", psi, &excitation, &acting, sensors, self.case.seed);
        plant.record(&Experiment { longest_step_s: LONGEST_STEP_S, ..run })
    }

    /// What a model without faults predicts from the sealed reading of a recording.
    fn predicted(&self, model: &Plant, i: usize, of: &Recording) -> Recording {
        let rest = of.reading_at_rest();
        let psi = [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa]
            .map(|kpa| (kpa - ATMOSPHERE_KPA) / KPA_PER_PSI);
        self.record(model, i, psi, &[], &self.quiet)
    }

    /// The size of a fault.
    #[must_use]
    pub fn size(&self, fault: &Hidden) -> f64 {
        norm(&self.nuisances.orthogonal(self.residual(fault)))
    }

    /// The size of what is left of a fault beside others, whose values are free.
    #[must_use]
    pub fn size_beside(&self, fault: &Hidden, others: &[&Hidden]) -> f64 {
        let mut basis = self.nuisances.clone();
        for other in others {
            let whole = self.residual(other);
            for changed in changed(other) {
                basis.add(difference(&self.residual(&changed), &whole));
            }
            basis.add(whole);
        }
        norm(&basis.orthogonal(self.residual(fault)))
    }

    /// The residual that a fault leaves to a model without it, in all recordings and channels, scaled so that its norm is
    /// the size without nuisance parameters.
    fn residual(&self, fault: &Hidden) -> Vec<f64> {
        let of = |(i, &psi): (usize, &[f64; 2])| {
            let faulty = self.record(self.plant, i, psi, std::slice::from_ref(fault), &self.quiet);
            let expected = self.predicted(self.plant, i, &faulty);
            self.weighted_difference(&faulty, &expected, 1.0)
        };
        self.conditions.iter().enumerate().flat_map(of).collect()
    }

    /// A variant at a strength, with its size.
    #[must_use]
    pub fn scaled(&self, label: &str, strength: Strength) -> (Hidden, f64) {
        let at = |factor: f64| magnitudes::scaled(label, factor, &self.motion);
        let usual = self.size(&at(1.0)).max(f64::MIN_POSITIVE);
        let fault = at(factor(usual / LIMIT, strength));
        let size = self.size(&fault);
        (fault, size)
    }
}

/// Factor on the usual magnitude of a fault at a strength; `usual` is the size at the usual magnitude over the limit.
#[must_use]
pub fn factor(usual: f64, strength: Strength) -> f64 {
    let medium = (MEDIUM_LIMITS / usual).clamp(1.0, LARGEST_FACTOR);
    match strength {
        Strength::Weak => (WEAK_LIMITS / usual).clamp(SMALLEST_FACTOR, WEAK_FACTOR * medium),
        Strength::Medium | Strength::Given => medium,
        Strength::Strong => STRONG_FACTOR * medium,
    }
}

/// Relative change of a value by which the residual is differentiated.
const CHANGE: f64 = 0.1;
/// The two chambers in the names of parameters.
const SIDES: [&str; 2] = ["flexor_", "extensor_"];

/// An effect with each of its values changed in turn, those of the other chamber included.
fn changed(hidden: &Hidden) -> Vec<Hidden> {
    let mut names: Vec<String> = hidden.values.keys().cloned().collect();
    for (own, other) in [SIDES, [SIDES[1], SIDES[0]]].map(|[a, b]| (a, b)) {
        let more =
            hidden.values.keys().filter_map(|n| Some(format!("{other}{}", n.strip_prefix(own)?)));
        names.extend(more.collect::<Vec<_>>());
    }
    names.sort();
    names.dedup();
    let largest = hidden.values.values().fold(0.0_f64, |m, v| m.max(v.abs()));
    let with = |name: String| {
        let mut other = hidden.clone();
        let value = other.values.entry(name).or_default();
        *value += CHANGE * if *value == 0.0 { largest } else { *value };
        other
    };
    names.into_iter().map(with).collect()
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn force_correlation(noise: Noise, step_s: f64) -> f64 {
    noise.colour.correlation(step_s).min(0.999)
}
