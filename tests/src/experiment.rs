//! Limits of detection that are foretold, against those of diagnoses of a plant that shares no code with them.

use crate::diagnose::plant_runs;
use crate::plant::{Excitation, Hidden, Sensors};
use crate::study::outcome::cpu_s;
use pam_data::{SavedModel, Subject, load_model};
use pam_diagnose::{DiagnoseError, DiagnoseOptions, JointDiagnosis, RecordingSets, diagnose};
use pam_effects::ExtendedModel;
use pam_effects::effects::by_id;
use pam_experiment::certify::{Case, CertifyOptions, Outcome, Plan, plan};
use pam_experiment::detect::{DetectOptions, Detection, GivenValues, Pair, TRIALS};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

/// Gauge pressures of the recordings, psi.
pub const CONDITIONS: [[f64; 2]; 3] = [[40.0, 40.0], [70.0, 45.0], [35.0, 60.0]];
/// Length of a recording over that of the published protocol: 20 s.
pub const LENGTH: f64 = 20.0 / 70.0;
/// Multiples of the foretold limits at which effects are hidden.
pub const MULTIPLES: [f64; 5] = [0.5, 0.7, 1.0, 1.4, 2.0];
/// Seed of the recordings from which the limits are foretold.
const SEED: u64 = 4_000;

/// Effects with the scales at which the plant has them.
pub(crate) const EFFECTS: [&str; 28] = [
    "coulomb_friction",
    "stribeck_friction:velocity_mm_s=2",
    "load_friction",
    "viscous_damping",
    "hysteresis:slip_mm=0.5",
    "creep:time_constant_s=2",
    "constant_load",
    "added_inertia",
    "backlash",
    "cogging:pitch_mm=0.6",
    "tendon_slack:stiffness_loss=0.2",
    "stiffness_drift",
    "stiffness_scale",
    "leak",
    "polytropic_gas",
    "geometry_coefficient",
    "force_gain",
    "force_saturation",
    "actuation_delay",
    "actuator_lag",
    "pressure_sensor_lag",
    "pressure_delay",
    "pressure_bias",
    "pressure_gain",
    "position_offset",
    "position_gain",
    "position_sensor_lag",
    "position_delay",
];

/// The published model.
///
/// # Panics
/// If the weights cannot be read.
#[must_use]
pub fn published() -> SavedModel {
    load_model(crate::published_weights()).expect("the published weights")
}

/// Recordings of the plant.
#[must_use]
pub fn recordings(saved: &SavedModel, hidden: &[Hidden], seed: u64) -> Vec<Subject> {
    let excitation = Excitation::published(LENGTH);
    plant_runs(saved, &CONDITIONS, &excitation, hidden, &Sensors::default(), seed)
}

/// Foretold limits, with trials in recordings that the model simulates, and the sets of the plant that check them.
///
/// # Panics
/// If the limits cannot be foretold.
#[must_use]
pub fn foretold(saved: &SavedModel) -> (Plan, Detection) {
    let model = ExtendedModel::from_saved(saved.clone()).expect("known effects");
    let given = |e: &&str| e.parse::<GivenValues>().expect("an effect with values");
    let options = CertifyOptions {
        detect: DetectOptions {
            effects: EFFECTS.iter().map(given).collect(),
            trials: Some(TRIALS),
            ..DetectOptions::default()
        },
        multiples: MULTIPLES.to_vec(),
        repeats: 2,
        nulls: 0,
        seed: SEED,
        ..CertifyOptions::default()
    };
    plan(&model, &recordings(saved, &[], SEED), &options).expect("limits")
}

/// The diagnosis of the plant with the effect of a case.
///
/// # Errors
/// As [`diagnose`].
pub fn found(saved: &SavedModel, case: &Case) -> Result<JointDiagnosis, DiagnoseError> {
    let model = ExtendedModel::from_saved(saved.clone()).expect("known effects");
    let hidden = case.effect.as_deref().map(|id| {
        let info = by_id(id).expect("an effect of the vocabulary").info();
        let names: Vec<&str> = info.parameters.iter().map(|p| p.name).collect();
        let values: Vec<(&str, f64)> =
            names.iter().copied().zip(case.values.iter().copied()).collect();
        Hidden::new(id, &values)
    });
    let data = recordings(saved, hidden.as_slice(), case.seed % 1_000_000);
    let options = DiagnoseOptions { law: false, seed: case.seed, ..DiagnoseOptions::default() };
    let sets = RecordingSets { data: &data, ..RecordingSets::default() };
    diagnose(&model, &sets, &options, &|_, _| {})
}

/// Outcome of the diagnosis of a case.
#[must_use]
pub fn diagnosed(saved: &SavedModel, case: &Case) -> Outcome {
    let start = cpu_s().unwrap_or(f64::NAN);
    let took = || cpu_s().unwrap_or(f64::NAN) - start;
    match found(saved, case) {
        Ok(found) => Outcome::of(case, &found, took()),
        Err(e) => Outcome::refused(case, e.to_string(), took()),
    }
}

/// A foretold limit beside the measured one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Compared {
    /// Label of the effect.
    pub label: String,
    /// Its parameter.
    pub parameter: String,
    /// The foretold value from which it is named with 90 % power.
    pub foretold: f64,
    /// Multiples of the limit at which it was hidden, and whether it was named.
    pub trials: Vec<(f64, bool)>,
    /// The measured limit over the foretold one, by maximum likelihood.
    pub ratio: f64,
}

/// Ratios that are tried.
const RATIOS: usize = 400;
/// Steepness of the probability that an effect is named.
const STEEPNESS: f64 = 4.0;

/// The limits of a plan beside those that outcomes show.
#[must_use]
pub fn compared(detection: &Detection, outcomes: &[Outcome]) -> Vec<Compared> {
    let mut all = Vec::new();
    for limits in &detection.limits {
        let Some(limit) = limits.named else { continue };
        let own = outcomes.iter().filter(|o| o.case.label.as_deref() == Some(&limits.label));
        let trials: Vec<(f64, bool)> = own.map(|o| (o.case.multiple, o.is_named())).collect();
        if trials.is_empty() {
            continue;
        }
        all.push(Compared {
            label: limits.label.clone(),
            parameter: limits.parameter.clone(),
            foretold: limit.value,
            ratio: ratio(&trials),
            trials,
        });
    }
    all
}

/// The factor on the limit under which the trials are most probable, where the limit has 90 % power. Of factors that are equally
/// probable the geometric mean.
fn ratio(trials: &[(f64, bool)]) -> f64 {
    let normal = Normal::standard();
    let needed = STEEPNESS - normal.inverse_cdf(0.9);
    let likelihood = |ratio: f64| -> f64 {
        let of = |&(multiple, named): &(f64, bool)| {
            let power = normal.cdf(STEEPNESS * multiple / ratio - needed).clamp(0.01, 0.99);
            if named { power.ln() } else { (1.0 - power).ln() }
        };
        trials.iter().map(of).sum()
    };
    let tried: Vec<(f64, f64)> = (0..RATIOS)
        .map(|k| {
            let ratio = 0.25 * 16.0_f64.powf(k as f64 / RATIOS as f64);
            (ratio, likelihood(ratio))
        })
        .collect();
    let best = tried.iter().map(|t| t.1).fold(f64::NEG_INFINITY, f64::max);
    let near: Vec<f64> = tried.iter().filter(|t| t.1 > best - 0.05).map(|t| t.0.ln()).collect();
    (near.iter().sum::<f64>() / near.len() as f64).exp()
}

/// An effect and another one that diagnoses may take for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Confusion {
    /// Label of the hidden effect.
    pub hidden: String,
    /// Id of the other one.
    pub other: String,
    /// Whether `detect` predicts that a diagnosis cannot distinguish the two.
    pub foretold: bool,
    /// Diagnoses with the right name, at the foretold limit or beyond, that name the other one as well or do not distinguish the
    /// two.
    pub confused: usize,
    /// All of these diagnoses.
    pub trials: usize,
}

impl Confusion {
    /// Whether at least half of the diagnoses confuse the two: the rule by which [`Pair`] counts its own trials.
    #[must_use]
    pub fn is_measured(&self) -> bool {
        2 * self.confused >= self.trials
    }
}

/// The pairs that are foretold to be confused at the foretold limit, and those that a diagnosis confused at least once.
#[must_use]
pub fn confusions(detection: &Detection, outcomes: &[Outcome]) -> Vec<Confusion> {
    let of_pair = |pair: &Pair| {
        // Below its limit an effect is not foretold to be found at all.
        let own = outcomes.iter().filter(|o| {
            o.case.label.as_ref() == Some(&pair.effect) && o.is_right() && o.case.multiple >= 1.0
        });
        let names_other = |o: &&Outcome| {
            o.named
                .iter()
                .any(|n| n.effect == pair.other || n.confusable_with.contains(&pair.other))
        };
        Confusion {
            hidden: pair.effect.clone(),
            other: pair.other.clone(),
            foretold: pair.is_confused(1.0),
            confused: own.clone().filter(names_other).count(),
            trials: own.count(),
        }
    };
    let all = detection.pairs.iter().map(of_pair);
    all.filter(|c| c.trials > 0 && (c.foretold || c.confused > 0)).collect()
}

/// Of these pairs: how many are foretold and measured, only foretold, only measured.
#[must_use]
pub fn agreement(confusions: &[Confusion]) -> [usize; 3] {
    let count = |foretold, measured| {
        confusions.iter().filter(|c| c.foretold == foretold && c.is_measured() == measured).count()
    };
    [count(true, true), count(true, false), count(false, true)]
}

/// Diagnoses cases in parallel; `done` is called for each.
#[must_use]
pub fn run(saved: &SavedModel, cases: &[Case], done: &(dyn Fn(&Outcome) + Sync)) -> Vec<Outcome> {
    let one = |case: &Case| {
        let outcome = diagnosed(saved, case);
        done(&outcome);
        outcome
    };
    cases.par_iter().map(one).collect()
}
