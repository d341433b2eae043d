//! Joints to differentiate.
#![allow(dead_code, missing_docs)]

use pam_core::force::Dense;
use pam_core::{
    Activation, Chambers, JointField, JointModel, Mlp, NetworkForce, SealedMasses, SpringDamper,
};

/// A network of the given widths with arbitrary weights.
pub(crate) fn network(activation: &str, hidden: &[usize]) -> NetworkForce<f64> {
    let activation = Activation::from_name(activation).unwrap();
    let widths: Vec<usize> = [4].into_iter().chain(hidden.iter().copied()).chain([1]).collect();
    let layers = widths
        .windows(2)
        .enumerate()
        .map(|(l, pair)| {
            let value = |k: usize| (k as f64 * 1.7 + l as f64).sin() / (pair[0] as f64).sqrt();
            let weights: Vec<f64> = (0..pair[0] * pair[1]).map(value).collect();
            Dense::from_rows(&weights, (0..pair[1]).map(|k| value(k + 5)).collect()).unwrap()
        })
        .collect();
    NetworkForce::new(Mlp::new(layers, activation).unwrap()).unwrap()
}

pub(crate) fn masses() -> SealedMasses {
    SealedMasses { flexor_g: 0.06, extensor_g: 0.08 }
}

pub(crate) fn joint<F>(force: F, sealed: bool) -> JointField<f64, F> {
    let mut model = JointModel::datasheet(force);
    model.auxiliary_damping_kg_s = 700.0;
    let chambers = if sealed { Chambers::Sealed(masses()) } else { Chambers::OpenValves };
    JointField::new(model, chambers)
}

pub(crate) fn spring() -> SpringDamper<f64> {
    SpringDamper::published()
}

/// A state of the joint and an input.
pub(crate) fn operating_point(sealed: bool) -> (Vec<f64>, Vec<f64>) {
    if sealed {
        (vec![0.7, -3.0, 320.0, 410.0], vec![9e3])
    } else {
        (vec![0.7, -3.0, 320.0, 410.0, 0.06, 0.08], vec![9e3, 0.02, -0.01])
    }
}
