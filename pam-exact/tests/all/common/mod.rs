//! The published joint, its training conditions and its excitation.

#![allow(dead_code)]

pub(crate) mod landing;
pub(crate) mod limits;
pub(crate) mod random;

use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI, tendon_force_mn_per_a};
use pam_core::{AnyForce, JointModel, NetworkForce, SealedMasses};
use pam_exact::ExactMotion;
use std::f64::consts::TAU;
use std::path::Path;

pub(crate) type Joint = JointModel<f64, NetworkForce<f64>>;

pub(crate) fn published() -> Joint {
    let path = "../data/published/hybrid_model_puresine_16.eqx";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let model = pam_data::load_model(&path).expect("the published weights").model;
    let AnyForce::Network(force) = &model.force else { panic!("the force is a network") };
    model.map(|v| v, |_| force.clone())
}

/// Every weight × 1.02, raw m × 1.05: where gradients are compared.
pub(crate) fn perturbed() -> Joint {
    let mut model = published().map(|v| v, |force| force.map(|w| 1.02 * w));
    model.raw.mass *= 1.05;
    model
}

pub(crate) fn motion(model: &Joint) -> ExactMotion {
    ExactMotion::new(model).unwrap()
}

/// The masses of the first `count` training conditions.
pub(crate) fn masses(count: usize) -> Vec<SealedMasses> {
    let model = published();
    pam_data::conditions::TRAINING_PSI[..count]
        .iter()
        .map(|condition| {
            let kpa = condition.map(|psi| f64::from(psi) * KPA_PER_PSI + ATMOSPHERE_KPA);
            model.gas_law_masses(0.0, kpa)
        })
        .collect()
}

/// Times (s) at 1 kHz and the published excitation (mN), for `samples` samples from `from_s` on.
pub(crate) fn excitation(from_s: f64, samples: usize) -> (Vec<f64>, Vec<f64>) {
    let times: Vec<f64> = (0..samples).map(|k| k as f64 * 1e-3).collect();
    let force = times
        .iter()
        .map(|t| {
            let t = t + from_s;
            let (start, frequency, middle) = match t {
                t if t < 40.0 => (0.0, 0.5, 20.0),
                t if t < 60.0 => (40.0, 1.0, 50.0),
                _ => (60.0, 2.0, 65.0),
            };
            let amplitude = if t < middle { 1.0 } else { 1.5 };
            tendon_force_mn_per_a() * amplitude * (TAU * frequency * (t - start)).sin()
        })
        .collect();
    (times, force)
}
