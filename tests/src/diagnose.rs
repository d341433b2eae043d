//! Runs of the diagnosis on data with something hidden in them, for tests and for the checked-in tables.

use crate::plant::{self, Excitation, Hidden, Noise};
use pam_core::AnyForce;
use pam_data::{
    LoadOptions, MassOrigin, Recording, SavedModel, Subject, collect_paths, open_recordings,
};
use pam_diagnose::{DiagnoseOptions, JointDiagnosis, RecordingSets, diagnose};
use pam_effects::ExtendedModel;
use pam_rig::protocol::CurrentSegment;
use pam_rig::{Conditions, Protocol, RigParameters, Session};
use rayon::prelude::*;

/// A recording with its masses by the model's gas law.
#[must_use]
pub fn subject(saved: &SavedModel, recording: Recording) -> Subject {
    let masses = plant::masses(&saved.model, &recording);
    Subject { recording, masses, origin: MassOrigin::GasLaw }
}

/// Runs of a plant that is the model itself, at several pressures, with hidden effects.
#[must_use]
pub fn plant_runs(
    saved: &SavedModel,
    conditions: &[[f64; 2]],
    excitation: &Excitation,
    effects: &[Hidden],
    noise: Noise,
    seed: u64,
) -> Vec<Subject> {
    let model: &pam_core::JointModel<f64, AnyForce<f64>> = &saved.model;
    conditions
        .par_iter()
        .enumerate()
        .map(|(i, &psi)| {
            let name = format!("nn_{:.0}{:.0}", psi[0], psi[1]);
            let seed = seed * 1000 + i as u64;
            let run = plant::record(model, &name, psi, excitation, effects, noise, seed);
            subject(saved, run)
        })
        .collect()
}

/// Runs of the virtual rig, through its raw logs: the published excitation with its times multiplied.
/// `effects` are written as for the command, `coulomb_friction:force_n=20`.
///
/// # Panics
/// If an effect is not known to the rig or a file cannot be written.
#[must_use]
pub fn rig_runs(
    saved: &SavedModel,
    conditions: &[[u8; 2]],
    share: f64,
    effects: &[&str],
    ideal: bool,
    seed: u64,
) -> Vec<Subject> {
    let folder = tempfile::tempdir().expect("a folder for the logs");
    let mut rig = RigParameters::default();
    if ideal {
        rig.sensors = pam_rig::sensors::SensorParameters::ideal();
    }
    rig.effects = effects.iter().map(|e| e.parse().expect("an effect of the rig")).collect();
    let mut protocol = Protocol::paper();
    for segment in &mut protocol.current {
        if let CurrentSegment::Sine { duration_s, .. } = segment {
            *duration_s *= share;
        }
    }
    protocol.conditions = Some(Conditions::List(conditions.to_vec()));
    let session = Session { rig, protocol, seed, truth: false, note: String::new() };
    session.record_into(folder.path(), true, &|_| {}).expect("the rig records");
    let mut paths = collect_paths(&[folder.path().to_owned()]).expect("logs");
    paths.sort();
    paths
        .par_iter()
        .map(|p| {
            let runs = open_recordings(p, &LoadOptions::default()).expect("a log");
            subject(saved, runs.into_iter().next().expect("a recording"))
        })
        .collect()
}

/// A diagnosis with default options.
///
/// # Panics
/// If it cannot be made.
#[must_use]
pub fn diagnosed(
    saved: &SavedModel,
    data: &[Subject],
    healthy: Option<&[Subject]>,
    seed: u64,
) -> JointDiagnosis {
    let model = ExtendedModel::from_saved(saved.clone()).expect("known effects");
    let options = DiagnoseOptions { seed, ..DiagnoseOptions::default() };
    diagnose(&model, &RecordingSets { data, test: None, baseline: healthy }, &options, &|_, _| {})
        .expect("a diagnosis")
}

/// An effect at medium strength: id, parameters, and the names of those that grow with the strength.
pub type Medium = (&'static str, Vec<(&'static str, f64)>, &'static [&'static str]);

/// Typical magnitudes of every listed effect for a study.
#[must_use]
pub fn vocabulary() -> Vec<Medium> {
    vec![
        ("coulomb_friction", vec![("force_n", 12.0)], &["force_n"]),
        (
            "stribeck_friction",
            vec![("coulomb_n", 8.0), ("static_n", 20.0), ("velocity_mm_s", 2.0)],
            &["coulomb_n", "static_n"],
        ),
        ("viscous_damping", vec![("coefficient_ns_m", 800.0)], &["coefficient_ns_m"]),
        ("hysteresis", vec![("force_n", 15.0), ("slip_mm", 0.5)], &["force_n"]),
        ("creep", vec![("stiffness_n_mm", 8.0), ("time_constant_s", 2.0)], &["stiffness_n_mm"]),
        ("constant_load", vec![("force_n", 12.0)], &["force_n"]),
        ("added_inertia", vec![("mass_kg", 35.0)], &["mass_kg"]),
        ("backlash", vec![("gap_mm", 0.1)], &["gap_mm"]),
        ("cogging", vec![("force_n", 7.0), ("pitch_mm", 0.6)], &["force_n"]),
        (
            "tendon_slack",
            vec![("displacement_mm", 0.9), ("stiffness_loss", 0.2)],
            &["stiffness_loss"],
        ),
        ("stiffness_drift", vec![("relative_per_min", 0.12)], &["relative_per_min"]),
        ("stiffness_scale", vec![("relative", 0.07)], &["relative"]),
        (
            "leak",
            vec![("flexor_rate_per_s", 1.5e-3), ("extensor_rate_per_s", 7e-4)],
            &["flexor_rate_per_s", "extensor_rate_per_s"],
        ),
        ("polytropic_gas", vec![("exponent", 1.2)], &[]),
        ("geometry_coefficient", vec![("relative", 0.08)], &["relative"]),
        ("force_gain", vec![("relative", -0.07)], &["relative"]),
        ("force_saturation", vec![("force_n", 165.0)], &[]),
        ("actuation_delay", vec![("delay_ms", 10.0)], &["delay_ms"]),
        ("pressure_sensor_lag", vec![("cutoff_hz", 5.0)], &[]),
        ("pressure_delay", vec![("delay_ms", 25.0)], &["delay_ms"]),
        (
            "pressure_bias",
            vec![("flexor_kpa", 12.0), ("extensor_kpa", -8.0)],
            &["flexor_kpa", "extensor_kpa"],
        ),
        (
            "pressure_gain",
            vec![("flexor_relative", 0.05), ("extensor_relative", -0.04)],
            &["flexor_relative", "extensor_relative"],
        ),
        ("position_offset", vec![("offset_mm", 0.12)], &["offset_mm"]),
        ("position_gain", vec![("relative", 0.04)], &["relative"]),
    ]
}

/// An effect of the vocabulary at a multiple of its medium strength; scales that have no natural zero move
/// towards their stronger side.
#[must_use]
pub fn at_strength(id: &str, strength: f64) -> Hidden {
    let all = vocabulary();
    let (_, values, grows) = all.iter().find(|v| v.0 == id).expect("an id of the vocabulary");
    let values: Vec<(&str, f64)> = values
        .iter()
        .map(|&(name, value)| {
            let value = match (id, name) {
                ("polytropic_gas", _) => 1.0 + (value - 1.0) * strength,
                // The largest force is 200 N.
                ("force_saturation", _) => 200.0 - (200.0 - value) * strength,
                ("pressure_sensor_lag", _) => value / strength,
                _ if grows.contains(&name) => value * strength,
                _ => value,
            };
            (name, value)
        })
        .collect();
    plant::hidden(id, &values)
}

/// A hidden effect as the rig's command line writes it.
#[must_use]
pub fn as_text(hidden: &Hidden) -> String {
    let values: Vec<String> = hidden.1.iter().map(|(k, v)| format!("{k}={v}")).collect();
    format!("{}:{}", hidden.0, values.join(","))
}
