//! Benchmarks: the comparison of gradient methods ([`gradients`], the command `pam-bench`), the memory that work takes
//! ([`memory`]), the measured results of all studies ([`results`]), and what the timings of `cargo bench -p pam-bench --features
//! criterion` work on: the published weights, and
//! recordings of the published length. The weights are read from `data/published` of the workspace; the comparison of
//! gradient methods needs none.

pub mod gradients;
pub mod memory;
pub mod results;

use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI, MN_PER_N, tendon_force_mn_per_a};
use pam_core::{AnyForce, JointModel, NetworkForce, SealedMasses};
use pam_data::Subject;
use pam_data::formats::raw_log::{Row, to_text};
use pam_data::preprocess::LowPass;
use pam_data::{MassOrigin, Recording, load_model};
use pam_trajectory::{SolverSettings, predict};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::path::Path;

/// Samples of a 70 s recording at 1 kHz.
pub const SAMPLES: usize = 70_000;

/// The published model.
///
/// # Panics
/// If the reference data are missing.
#[must_use]
pub fn published_model() -> JointModel<f64, AnyForce<f64>> {
    let path = "../data/published/hybrid_model_puresine_16.eqx";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    load_model(&path).expect("the published weights").model
}

/// The published excitation over 70 s, A: 0.5 Hz to 40 s, 1 Hz to 60 s, 2 Hz to 70 s, each at 1 A and
/// at 1.5 A.
#[must_use]
pub fn excitation_a(t: f64) -> f64 {
    let (start, frequency, middle) = match t {
        t if t < 40.0 => (0.0, 0.5, 20.0),
        t if t < 60.0 => (40.0, 1.0, 50.0),
        _ => (60.0, 2.0, 65.0),
    };
    let amplitude = if t < middle { 1.0 } else { 1.5 };
    amplitude * (TAU * frequency * (t - start)).sin()
}

/// Evenly spread numbers in ±1, the same every time.
fn noise() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    }
}

/// The model with its network as such.
///
/// # Panics
/// If its force is none.
#[must_use]
pub fn network_model(model: &JointModel<f64, AnyForce<f64>>) -> JointModel<f64, NetworkForce<f64>> {
    let AnyForce::Network(force) = &model.force else { panic!("the force is a network") };
    model.map(|v| v, |_| force.clone())
}

/// A 70 s recording of the joint at 412 kPa under the published excitation. With `current_noise_a`
/// above zero the force carries noise of that size, filtered as the loader filters it.
///
/// # Panics
/// Never: the filter's cutoff is below half the sample rate.
#[must_use]
pub fn recording(
    model: &JointModel<f64, AnyForce<f64>>,
    current_noise_a: f64,
) -> (Recording, SealedMasses) {
    let masses = model.gas_law_masses(0.0, [412.0, 412.0]);
    let mut recording = Recording::empty(Path::new("bench"));
    let mut noise = noise();
    recording.time_s = (0..SAMPLES).map(|k| k as f64 * 1e-3).collect();
    recording.force_mn = recording
        .time_s
        .iter()
        .map(|&t| tendon_force_mn_per_a() * (excitation_a(t) + current_noise_a * noise()))
        .collect();
    if current_noise_a > 0.0 {
        let filter = LowPass::new(20.0, 1000.0).expect("20 Hz is below 500 Hz");
        recording.force_mn = filter.forward_backward(&recording.force_mn);
    }
    recording.displacement_mm = vec![0.0; SAMPLES];
    recording.velocity_mm_s = vec![0.0; SAMPLES];
    recording.pressure_flexor_kpa = vec![412.0; SAMPLES];
    recording.pressure_extensor_kpa = vec![412.0; SAMPLES];
    debug_assert!(recording.force_mn.iter().all(|f| f.abs() < 400.0 * MN_PER_N));
    (recording, masses)
}

pub use pam_data::conditions::TRAINING_PSI;

/// The first `count` training conditions under the published excitation for `seconds`, as `model`
/// answers to it; no noise.
///
/// # Panics
/// If the model cannot follow the excitation.
#[must_use]
pub fn training_set(
    model: &JointModel<f64, AnyForce<f64>>,
    count: usize,
    seconds: f64,
) -> Vec<Subject> {
    let (template, _) = recording(model, 0.0);
    let template = template.slice(0..((seconds * 1000.0) as usize).min(SAMPLES));
    TRAINING_PSI[..count]
        .par_iter()
        .map(|&condition| {
            let kpa = condition.map(|psi| f64::from(psi) * KPA_PER_PSI + ATMOSPHERE_KPA);
            let masses = model.gas_law_masses(0.0, kpa);
            let mut start = template.clone();
            start.name = pam_data::conditions::name_of(condition);
            start.pressure_flexor_kpa[0] = kpa[0];
            start.pressure_extensor_kpa[0] = kpa[1];
            let settings = SolverSettings::default();
            let prediction = predict(model, &start, masses, &settings)
                .expect("the joint follows the excitation");
            let recording =
                Recording { name: start.name.clone(), ..prediction.to_recording(&start, masses) };
            Subject { recording, masses, origin: MassOrigin::Given }
        })
        .collect()
}

/// `model` with every number of its force × 1.02 and raw m × 1.05, where gradients are compared: at
/// the weights that made the data they are noise.
#[must_use]
pub fn perturbed(model: &JointModel<f64, AnyForce<f64>>) -> JointModel<f64, AnyForce<f64>> {
    let mut model = model.map(|v| v, |force| force.map(|w| 1.02 * w));
    model.raw.mass *= 1.05;
    model
}

/// The text of a raw log of 73 s, about 7 MB, as the rig writes it.
#[must_use]
pub fn raw_log_text() -> String {
    let mut noise = noise();
    let rows: Vec<Row> = (0..SAMPLES + 3000)
        .map(|k| {
            let t = k as f64 * 1e-3 - 3.0;
            let current = if t < 0.0 { 0.0 } else { excitation_a(t) };
            Row {
                angle_deg: 0.878_906 + 10.0 * current + 0.01 * noise(),
                command: 2047.0 + 800.0 * current,
                current_a: current + 0.05 * noise(),
                commanded_psi: [45.0, 45.0],
                measured_psi: [45.0 + 2.0 * current + 0.01 * noise(), 45.0 - 2.0 * current],
                valves: [-1; 2],
                sync: t >= 0.0,
                ..Row::default()
            }
        })
        .collect();
    to_text("bench", 1000.0, 6240, &rows)
}
