//! False alarms with certified settings: recordings of the virtual rig in which nothing is hidden, diagnosed with models whose
//! weights are off.

use crate::pairs::{limits, model, recorded};
use pam_core::{AnyForce, ParametricForce};
use pam_data::Subject;
use pam_diagnose::{DiagnoseOptions, DiagnosisSettings, RecordingSets, diagnose};
use pam_effects::ExtendedModel;
use pam_experiment::certify::{
    CertifyFolder, CertifyOptions, Summary, Work, plan, run_cases, settings_file, with_baseline,
};
use pam_experiment::design::standard;
use pam_experiment::plan::Synthesis;
use pam_rig::RigParameters;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Relative errors of every weight.
pub const OFF: [f64; 3] = [0.0, 0.01, 0.03];
/// Samples per second.
pub const RATES_HZ: [f64; 7] = [25.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0];
/// Null sets of a certificate: enough for one alarm by the exact limit.
const CERTIFIED_NULLS: usize = 100;
/// Seed of the rig's first recordings.
const SEED: u64 = 91_000;

/// One null set of the rig.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NullCase {
    /// Relative error of each of the model's weights.
    pub off: f64,
    /// Samples per second.
    pub rate_hz: f64,
    /// Whether the noise of the pressures is coloured by the low-pass filter of the sensors.
    pub coloured: bool,
    /// Whether baseline recordings are given.
    pub baseline: bool,
    /// Seed of the rig.
    pub seed: u64,
}

/// Balanced null sets: all combinations of model, rate and noise by turns.
#[must_use]
pub fn cases(count: usize, baseline: bool) -> Vec<NullCase> {
    let one = |k: usize| NullCase {
        off: OFF[k % 3],
        rate_hz: RATES_HZ[k % 7],
        coloured: k.is_multiple_of(2),
        baseline,
        seed: SEED + 10 * (k as u64 + 1),
    };
    (0..count).map(one).collect()
}

/// The shipped model with every weight off by this share of itself, up or down at random.
///
/// # Panics
/// If the model has no network.
#[must_use]
pub fn model_off_by(off: f64) -> ExtendedModel {
    let mut model = model();
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let AnyForce::Network(force) = &model.joint.force else { panic!("a network") };
    let moved = |w: &f64| if random.random_bool(0.5) { w * (1.0 + off) } else { w * (1.0 - off) };
    let weights: Vec<f64> = force.parameters().iter().map(moved).collect();
    model.joint.force = AnyForce::Network(force.with_parameters(&weights));
    model
}

fn three_runs(model: &ExtendedModel, rig: RigParameters, seed: u64) -> Vec<Subject> {
    recorded(model, rig, &standard(&limits()), seed)
}

/// The certificate of a model by baseline recordings of the rig, with its settings.
///
/// # Panics
/// If it cannot be made.
#[must_use]
pub fn certified(model: &ExtendedModel) -> (DiagnosisSettings, Summary) {
    let baseline = three_runs(model, RigParameters::default(), SEED);
    let mut options =
        CertifyOptions { repeats: 0, nulls: CERTIFIED_NULLS, ..CertifyOptions::default() };
    options.detect.diagnosis.law = false;
    options.detect.diagnosis =
        with_baseline(model, &baseline, &options.detect.diagnosis).expect("a discrepancy");
    let diagnosis = &options.detect.diagnosis;
    let (plan, _) = plan(model, &baseline, &options).expect("a plan");
    let synthesis = Synthesis::new(model, &baseline, diagnosis).expect("in range");
    let at = tempfile::tempdir().expect("a folder");
    let folder = CertifyFolder::at(at.path());
    let work = Work {
        model,
        baseline: &baseline,
        synthesis: &synthesis,
        plan: &plan,
        diagnosis,
        folder: &folder,
    };
    let jobs = rayon::current_num_threads();
    let _ = run_cases(&work, &|_| true, jobs, &AtomicBool::new(false), &|_| {}).expect("outcomes");
    let outcomes = folder.outcomes(&plan).expect("outcomes");
    let summary = Summary::of(&plan, &outcomes, &options, "");
    let settings = settings_file(&summary, &diagnosis.settings);
    let (settings, _) =
        pam_experiment::certify::Certificate::split(&settings).expect("a file of settings");
    (toml::from_str(&settings).expect("settings"), summary)
}

/// The outcome of a diagnosis of a null set with certified settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NullOutcome {
    /// The set.
    pub case: NullCase,
    /// The verdict.
    pub verdict: String,
    /// Ids of named causes.
    pub named: Vec<String>,
    /// Time, s.
    pub wall_s: f64,
}

/// Records a null set and diagnoses it with these settings.
///
/// # Panics
/// If the rig or the diagnosis fails.
#[must_use]
pub fn diagnosed(
    model: &ExtendedModel,
    settings: &DiagnosisSettings,
    case: &NullCase,
) -> NullOutcome {
    let clock = Instant::now();
    let mut rig = RigParameters::default();
    rig.sensors.clock.rate_hz = case.rate_hz;
    if !case.coloured {
        rig.sensors.pressure.cutoff_hz = 0.0;
    }
    let data = three_runs(model, rig.clone(), case.seed);
    let baseline = case.baseline.then(|| three_runs(model, rig, case.seed + 1));
    let options = DiagnoseOptions { law: false, settings: *settings, ..DiagnoseOptions::default() };
    let sets =
        RecordingSets { data: &data, baseline: baseline.as_deref(), ..RecordingSets::default() };
    let found = diagnose(model, &sets, &options, &|_, _| {}).expect("a diagnosis");
    NullOutcome {
        case: *case,
        verdict: found.verdict.to_string(),
        named: found.causes.iter().map(|c| c.effect.clone()).collect(),
        wall_s: clock.elapsed().as_secs_f64(),
    }
}
