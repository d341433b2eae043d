//! A small model, its candidates and recordings.

use pam_core::{AnyForce, JointModel, SpringDamper};
use pam_data::{ModelInfo, Subject};
use pam_diagnose::DiagnoseOptions;
use pam_diagnose::noise::Noise;
use pam_effects::effects::by_id;
use pam_effects::{ActiveEffect, ExtendedModel};
use pam_experiment::plan::{measured, noise_from_toml, planned_runs};
use pam_rig::sensors::SensorParameters;
use pam_rig::{Conditions, Protocol};

/// A joint with a linear spring and damper.
pub(crate) fn model() -> ExtendedModel {
    let joint = JointModel::datasheet(AnyForce::from(SpringDamper::published()));
    ExtendedModel { joint, info: ModelInfo::default(), effects: Vec::new() }
}

/// The published excitation in a few seconds at three pressures.
pub(crate) fn protocol(seconds: f64) -> Protocol {
    Protocol {
        conditions: Some(Conditions::List(vec![[45, 45], [30, 60], [60, 30]])),
        ..Protocol::paper().with_duration(seconds)
    }
}

/// A diagnosis with a few candidates.
pub(crate) fn diagnosis(ids: &[&str]) -> DiagnoseOptions {
    let candidates = ids.iter().map(|id| by_id(id).expect("a known effect")).collect();
    DiagnoseOptions { candidates, law: false, ..DiagnoseOptions::default() }
}

/// Simulated recordings of a protocol, without noise.
pub(crate) fn clean(model: &ExtendedModel, protocol: &Protocol) -> Vec<Subject> {
    let runs = planned_runs(protocol, &SensorParameters::default().motor, 500.0, 1).expect("runs");
    runs.iter().map(|run| run.simulated(model).expect("a simulation")).collect()
}

/// The same with an effect, as the sensors of the rig read it.
pub(crate) fn noisy(
    model: &ExtendedModel,
    protocol: &Protocol,
    effect: Option<(&str, f64)>,
    seed: u64,
) -> Vec<Subject> {
    let active = |(id, value): (&str, f64)| ActiveEffect {
        effect: by_id(id).expect("a known effect"),
        values: vec![value],
    };
    let plant = model.with(effect.map(active));
    let sensors = SensorParameters::default();
    let all = clean(&plant, protocol);
    let read = |(k, s): (usize, &Subject)| {
        measured(s, &sensors, 20.0, 100 * seed + k as u64).expect("long enough")
    };
    all.iter().enumerate().map(read).collect()
}

/// White noise of a size.
pub(crate) fn noise(size: f64) -> Noise {
    let text = format!(
        "x_mm = {{ deviation = {} }}\npressure_flexor_kpa = {{ deviation = {} }}\npressure_extensor_kpa = {{ deviation = {} }}",
        0.004 * size,
        0.1 * size,
        0.1 * size
    );
    noise_from_toml(&text, "noise.toml", 0.02).expect("a noise")
}
