//! The runs of a protocol, simulated by a model.

use crate::error::ExperimentError;
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI, MN_PER_N};
use pam_core::{ForceInput, ForceModel};
use pam_data::recording::SealedReading;
use pam_data::{Recording, Subject};
use pam_effects::effects::by_id;
use pam_effects::{ActiveEffect, ExtendedModel};
use pam_rig::Protocol;
use pam_rig::sensors::MotorParameters;
use pam_trajectory::{Predictor, SolverSettings};

/// A run with sealed muscles: pressures and the force over time.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedRun {
    /// Its name.
    pub name: String,
    /// Sealed pressures of flexor and extensor, psi gauge.
    pub psi: [f64; 2],
    /// Time, s.
    pub time_s: Vec<f64>,
    /// External force, mN.
    pub force_mn: Vec<f64>,
}

/// The runs of a protocol, sampled at a rate; random segments are drawn from the seed.
///
/// # Errors
/// [`ExperimentError::Setting`] for a protocol that drives the pressures: models of sealed muscles cannot predict it.
pub fn planned_runs(
    protocol: &Protocol,
    motor: &MotorParameters,
    rate_hz: f64,
    seed: u64,
) -> Result<Vec<PlannedRun>, ExperimentError> {
    if !protocol.pressure.is_empty() {
        return Err(ExperimentError::setting(
            format!("protocol `{}`", protocol.name),
            "it drives the pressures; a diagnosis reads recordings with sealed muscles, so give `conditions` instead",
        ));
    }
    let samples = (protocol.duration_s() * rate_hz).round() as usize;
    let time_s: Vec<f64> = (0..samples).map(|k| k as f64 / rate_hz).collect();
    let force = |t: &f64| MN_PER_N * motor.force_n(motor.current_a(protocol.current_a(*t, seed)));
    let force_mn: Vec<f64> = time_s.iter().map(force).collect();
    let run = |run: pam_rig::Run| PlannedRun {
        name: run.name,
        psi: run.start_psi,
        time_s: time_s.clone(),
        force_mn: force_mn.clone(),
    };
    Ok(protocol.runs()?.into_iter().map(run).collect())
}

/// Largest displacement at which a joint may rest, mm.
const REST_MM: f64 = 10.0;

/// The displacement at which the restoring force of a model vanishes with the muscles sealed at these pressures there, mm.
fn rest_mm(model: &ExtendedModel, kpa: [f64; 2]) -> f64 {
    let joint = &model.joint;
    let mut work = vec![0.0; joint.force.work_len()];
    let mut force = |x: f64| {
        let masses = joint.gas_law_masses(x, kpa);
        let input = ForceInput {
            displacement_mm: x,
            velocity_mm_s: 0.0,
            mass_flexor_g: masses.flexor_g,
            mass_extensor_g: masses.extensor_g,
        };
        joint.force.restoring_force_mn(&input, &mut work)
    };
    let (mut low, mut high) = (-REST_MM, REST_MM);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if force(middle) > 0.0 { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

impl PlannedRun {
    /// What the model predicts: the joint starts at rest, sealed at the pressures of the run.
    ///
    /// # Errors
    /// [`ExperimentError::Simulation`] if the simulation diverges.
    pub fn simulated(&self, model: &ExtendedModel) -> Result<Subject, ExperimentError> {
        let kpa = self.psi.map(|p| p * KPA_PER_PSI + ATMOSPHERE_KPA);
        let x = rest_mm(model, kpa);
        let sealed = SealedReading {
            displacement_mm: x,
            pressure_flexor_kpa: kpa[0],
            pressure_extensor_kpa: kpa[1],
        };
        let command = Recording {
            displacement_mm: vec![x; self.time_s.len()],
            force_mn: self.force_mn.clone(),
            sealed: Some(sealed),
            ..Recording::at_rest(&self.name, self.time_s.clone(), kpa)
        };
        predicted(model, command)
    }
}

/// The prediction of a model along a recording, as a recording whose masses follow from its reading at rest.
///
/// The steps are those of the simulation of a diagnosis, also for a model without effects.
pub(crate) fn predicted(
    model: &ExtendedModel,
    command: Recording,
) -> Result<Subject, ExperimentError> {
    // An effect of no size: with effects a model is simulated as a diagnosis does it, which is also the fastest way.
    let nothing = by_id("viscous_damping").map(|effect| ActiveEffect { effect, values: vec![0.0] });
    let model = if model.effects.is_empty() { model.with(nothing) } else { model.clone() };
    let subject = Subject::of(command, &model.joint)?;
    let recording = &subject.recording;
    let prediction = model.predict(recording, subject.masses, &SolverSettings::default());
    let prediction = prediction
        .map_err(|e| ExperimentError::Simulation { run: e.name.clone(), why: e.why.clone() })?;
    let made = prediction.to_recording(recording, subject.masses);
    let recording = Recording { given_masses: recording.given_masses, ..made };
    Ok(Subject { recording, ..subject })
}
