//! The recordings of a case.

use super::case::{Case, Fault, Source};
use super::detection::Scale;
use super::model::perturbed;
use super::rig;
use crate::diagnose::{rig_runs, subject};
use crate::plant::{Experiment, Hidden, Plant};
use pam_data::{SavedModel, Subject, load_model, parse_model};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use std::path::Path;

/// Gauge pressures from which the conditions of a case are drawn, psi.
const LOWEST_PSI: usize = 25;
const STEP_PSI: usize = 5;
const LEVELS: usize = 11;

/// Baseline recordings: their number and longest duration (s).
const BASELINES: usize = 3;
const BASELINE_S: f64 = 20.0;

/// Added to the seed of baseline recordings, models and conditions, so that nothing repeats.
const BASELINE_SEED: u64 = 500_000;
const MODEL_SEED: u64 = 700_000;
const CONDITION_SEED: u64 = 900_000;

const ATMOSPHERE_KPA: f64 = 101.325;
const PUBLISHED_S: f64 = 70.0;

/// A hidden effect of a case, with its size relative to the limit of detection.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// The effect.
    pub hidden: Hidden,
    /// Size over the limit of detection.
    pub limits: Option<f64>,
    /// As `limits`, of what is left of it beside the other hidden effects, whose values are free.
    pub limits_beside: Option<f64>,
}

/// What the diagnosis of a case gets, and the truth.
#[derive(Debug)]
pub struct Data {
    /// The model under diagnosis.
    pub model: SavedModel,
    /// Recordings.
    pub subjects: Vec<Subject>,
    /// Baseline recordings.
    pub baseline: Option<Vec<Subject>>,
    /// What is hidden.
    pub truth: Vec<Truth>,
}

fn conditions(count: usize, seed: u64) -> Vec<[f64; 2]> {
    let mut random = ChaCha8Rng::seed_from_u64(CONDITION_SEED + seed);
    let mut psi = || (LOWEST_PSI + STEP_PSI * random.random_range(0..LEVELS)) as f64;
    (0..count).map(|_| [psi(), psi()]).collect()
}

/// Makes the recordings of a case.
///
/// # Panics
/// If a model cannot be read or the rig cannot write its logs.
#[must_use]
pub fn data(case: &Case) -> Data {
    let mut data = match case.factors.source {
        Source::Plant => of_plant(case),
        Source::Rig => of_rig(case),
    };
    if case.factors.gauge {
        for r in data.subjects.iter_mut().map(|s| &mut s.recording) {
            let columns = [&mut r.pressure_flexor_kpa, &mut r.pressure_extensor_kpa];
            columns.into_iter().flatten().for_each(|p| *p -= ATMOSPHERE_KPA);
            if let Some(sealed) = &mut r.sealed {
                sealed.pressure_flexor_kpa -= ATMOSPHERE_KPA;
                sealed.pressure_extensor_kpa -= ATMOSPHERE_KPA;
            }
        }
        let again = |s: &Subject| subject(&data.model, s.recording.clone());
        data.subjects = data.subjects.iter().map(again).collect();
    }
    data
}

/// The sizes of given effects, hidden in the recordings of a case of the plant.
///
/// # Panics
/// If the published weights cannot be read.
#[must_use]
pub fn sized(case: &Case, hidden: &[Hidden]) -> Vec<Truth> {
    let faults = hidden.iter().cloned().map(Fault::Given).collect();
    let case = Case { faults, ..case.clone() };
    truths(&case, &Setting::of(&case))
}

/// The plant, model and conditions of a case.
struct Setting {
    plant: Plant,
    /// The model under diagnosis.
    model: SavedModel,
    /// Gauge pressures at rest of each recording, psi.
    conditions: Vec<[f64; 2]>,
}

impl Setting {
    fn of(case: &Case) -> Self {
        let saved = load_model(crate::published_weights()).expect("the published weights");
        let plant = Plant::of(&saved.model);
        let model = perturbed(&saved, case.factors.model_error, MODEL_SEED + case.seed);
        let conditions = match case.conditions.as_slice() {
            [] => conditions(case.factors.recordings, case.seed),
            given => given.to_vec(),
        };
        Self { plant, model, conditions }
    }
}

/// The faults of a case with their sizes, alone and beside each other.
fn truths(case: &Case, setting: &Setting) -> Vec<Truth> {
    if case.faults.is_empty() {
        return Vec::new();
    }
    let Setting { plant, model, conditions } = setting;
    let scale = Scale::of(case, plant, &Plant::of(&model.model), conditions);
    let mut truth: Vec<Truth> =
        case.faults.iter().map(|fault| measured(&scale, case, fault)).collect();
    let hidden: Vec<Hidden> = truth.iter().map(|t| t.hidden.clone()).collect();
    if hidden.len() > 1 {
        for (k, t) in truth.iter_mut().enumerate() {
            let others: Vec<&Hidden> =
                hidden.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, h)| h).collect();
            let size = scale.size_beside(&hidden[k], &others);
            t.limits_beside = Some(size / super::detection::LIMIT);
        }
    }
    truth
}

fn of_plant(case: &Case) -> Data {
    let setting = Setting::of(case);
    let truth = truths(case, &setting);
    let Setting { plant, model, conditions } = setting;
    let hidden: Vec<Hidden> = truth.iter().map(|t| t.hidden.clone()).collect();
    let record = |psi: &[[f64; 2]], faults: &[Hidden], seed: u64, longest_s: f64| {
        let mut factors = case.factors.clone();
        factors.duration_s = factors.duration_s.min(longest_s);
        let sensors = factors.sensors();
        psi.par_iter()
            .enumerate()
            .map(|(i, &psi)| {
                let acting: Vec<Hidden> = faults.iter().filter(|f| f.acts_in(i)).cloned().collect();
                let excitation = factors.excitation(i, seed);
                let name = format!("nn_{:.0}{:.0}_{i}", psi[0], psi[1]);
                let seed = seed * 1000 + i as u64;
                let run = Experiment::new(&name, psi, &excitation, &acting, &sensors, seed);
                subject(&model, plant.record(&run))
            })
            .collect::<Vec<Subject>>()
    };
    let subjects = record(&conditions, &hidden, case.seed, f64::INFINITY);
    let seed = BASELINE_SEED + case.seed;
    let others = self::conditions(BASELINES, seed);
    let baseline = case.factors.baseline.then(|| record(&others, &[], seed, BASELINE_S));
    Data { model, subjects, baseline, truth }
}

fn measured(scale: &Scale<'_>, case: &Case, fault: &Fault) -> Truth {
    let (hidden, size) = match fault {
        Fault::Given(hidden) => (hidden.clone(), scale.size(hidden)),
        Fault::Drawn { label, strength, onset, only } => {
            let (mut hidden, mut size) = scale.scaled(label, *strength);
            if *onset > 0.0 || only.is_some() {
                hidden = hidden.from_s(onset * case.factors.duration_s);
                hidden.only.clone_from(only);
                size = scale.size(&hidden);
            }
            (hidden, size)
        }
    };
    let limits = Some(size / super::detection::LIMIT);
    Truth { hidden, limits, limits_beside: limits }
}

fn of_rig(case: &Case) -> Data {
    let bytes = include_bytes!("../../../pam-cli/models/default.safetensors");
    let model = parse_model(Path::new("default"), bytes).expect("the default model");
    let whole = |psi: [f64; 2]| psi.map(|p| p as u8);
    let psi: Vec<[u8; 2]> = match case.conditions.as_slice() {
        [] => conditions(case.factors.recordings, case.seed).into_iter().map(whole).collect(),
        given => given.iter().copied().map(whole).collect(),
    };
    let share = case.factors.duration_s / PUBLISHED_S;
    let healthy = rig_runs(&model, &psi, share, &[], false, case.seed);
    let errors = rig::Errors::of(&model.model, &healthy);
    let record = |hidden: &[Hidden]| {
        let texts: Vec<String> = hidden.iter().map(Hidden::text).collect();
        let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
        rig_runs(&model, &psi, share, &texts, false, case.seed)
    };
    let measured = |fault: &Fault| {
        let limits = |hidden: &Hidden| {
            errors.size(&record(std::slice::from_ref(hidden))) / super::detection::LIMIT
        };
        let hidden = match fault {
            Fault::Given(hidden) => hidden.clone(),
            Fault::Drawn { label, strength, .. } => {
                let usual = limits(&crate::magnitudes::at_strength(label, 1.0));
                crate::magnitudes::at_strength(label, super::detection::factor(usual, *strength))
            }
        };
        let limits = Some(limits(&hidden));
        Truth { hidden, limits, limits_beside: limits }
    };
    let truth: Vec<Truth> = case.faults.iter().map(measured).collect();
    let hidden: Vec<Hidden> = truth.iter().map(|t| t.hidden.clone()).collect();
    let subjects = record(&hidden);
    let others: Vec<[u8; 2]> =
        conditions(BASELINES, BASELINE_SEED).into_iter().map(whole).collect();
    let baseline = || rig_runs(&model, &others, share, &[], false, BASELINE_SEED + case.seed);
    let baseline = case.factors.baseline.then(baseline);
    Data { model, subjects, baseline, truth }
}
