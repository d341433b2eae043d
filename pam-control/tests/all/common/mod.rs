//! What the tests share.
#![allow(dead_code)]

use pam_control::synthesis::Target;
use pam_core::activation::Activation;
use pam_core::force::Dense;
use pam_core::{AnyForce, JointModel, Mlp, NetworkForce};
use std::path::Path;

pub(crate) fn published() -> JointModel<f64, AnyForce<f64>> {
    let path = "../data/published/hybrid_model_puresine_16.eqx";
    pam_data::load_model(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap().model
}

/// A target at rest.
pub(crate) fn at_rest(displacement_mm: f64, stiffness_n_mm: f64) -> Target {
    Target {
        time_s: 0.0,
        displacement_mm,
        velocity_mm_s: 0.0,
        acceleration_mm_s2: 0.0,
        stiffness_n_mm,
        load_mn: 0.0,
    }
}

/// A network that is no physical joint: forces of some newtons that wind about in the masses, so that
/// the consistent masses form several branches and K̂ has many extremes.
pub(crate) fn winding(activation: &str, seed: f64) -> JointModel<f64, AnyForce<f64>> {
    let value = |k: usize| ((seed + k as f64 * 1.313).sin() * 917.13).fract();
    let layer = |inputs: usize, outputs: usize, scales: &[f64], bias: f64, from: usize| {
        let weights: Vec<f64> = (0..inputs * outputs)
            .map(|k| scales[(k % inputs).min(scales.len() - 1)] * value(from + k))
            .collect();
        let biases = (0..outputs).map(|k| bias * value(from + 7919 + k)).collect();
        Dense::from_rows(&weights, biases).unwrap()
    };
    let layers = vec![
        layer(4, 24, &[90.0, 90.0, 0.8, 0.1], 7.0, 0),
        layer(24, 16, &[0.6], 1.0, 400),
        layer(16, 1, &[20e3], 0.0, 900),
    ];
    let activation = Activation::from_name(activation).unwrap();
    let force = NetworkForce::new(Mlp::new(layers, activation).unwrap()).unwrap();
    JointModel::datasheet(AnyForce::Network(force))
}
