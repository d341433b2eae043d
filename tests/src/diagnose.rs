//! Runs of the diagnosis on data with something hidden in them, for tests and for the checked-in tables.

use crate::plant::{self, Excitation, Experiment, Hidden, Plant, Sensors};
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
    sensors: &Sensors,
    seed: u64,
) -> Vec<Subject> {
    let plant = Plant::of(&saved.model);
    conditions
        .par_iter()
        .enumerate()
        .map(|(i, &psi)| {
            let name = format!("nn_{:.0}{:.0}", psi[0], psi[1]);
            let acting: Vec<Hidden> = effects.iter().filter(|e| e.acts_in(i)).cloned().collect();
            let seed = seed * 1000 + i as u64;
            let run = Experiment::new(&name, psi, excitation, &acting, sensors, seed);
            subject(saved, plant.record(&run))
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
    let options = DiagnoseOptions { seed, law: false, ..DiagnoseOptions::default() };
    diagnose(&model, &RecordingSets { data, test: None, baseline: healthy }, &options, &|_, _| {})
        .expect("a diagnosis")
}
