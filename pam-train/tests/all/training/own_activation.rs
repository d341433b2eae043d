//! An activation of another crate is trained without a name from a table, and the model is saved and read.

use pam_core::activation::NamedActivation;
use pam_core::{ActivationFunction, AnyForce, JointModel, Scalar, SpringDamper};
use pam_data::{ModelInfo, Recording, SavedModel, load_model, save_model};
use pam_train::training::Training;
use pam_trajectory::{Predictor, SolverSettings};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// `z / √(1 + z²)`.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Algebraic;

impl ActivationFunction for Algebraic {
    fn value<S: Scalar>(&self, z: S) -> S {
        z / (z * z + S::constant(1.0)).sqrt()
    }
}

impl NamedActivation for Algebraic {
    const NAME: &'static str = "algebraic";
}

fn recording(hz: f64) -> Recording {
    let plant = JointModel::datasheet(SpringDamper::constant(150e3, 6500.0));
    let masses = plant.gas_law_masses(0.0, [412.0, 412.0]);
    let time_s = (0..500).map(|k| 2e-3 * f64::from(k)).collect();
    let command = Recording::at_rest(&format!("{hz} Hz"), time_s, [412.0, 412.0])
        .with_force(move |t| 100e3 * (TAU * hz * t).sin());
    let run = plant.predict(&command, masses, &SolverSettings::default()).unwrap();
    run.to_recording(&command, masses)
}

#[test]
fn it_is_trained_with_a_closure_as_the_loss_saved_and_read() {
    let trained = Training::new([recording(1.0), recording(2.0)])
        .with_held_out([recording(1.5)])
        .with_hidden([12])
        .with_activation(Algebraic)
        .with_loss_fn(|measured, predicted, cotangents| {
            let share = 1.0 / predicted.len() as f64;
            let mut sum = 0.0;
            for ((p, x), w) in predicted.iter().zip(&measured.displacement_mm).zip(cotangents) {
                sum += share * (p[0] - x).powi(2);
                *w = [2.0 * share * (p[0] - x), 0.0, 0.0, 0.0];
            }
            sum
        })
        .with_setting("stage.1.matching.steps=300")
        .with_epochs(5)
        .run()
        .unwrap();
    let r2 = trained.run.results.last().unwrap().r2_held_out[0].unwrap();
    assert!(r2 > 0.9, "{r2}");
    assert_eq!(trained.model.force.mlp().activation().name(), "algebraic");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.safetensors");
    let model = trained.model.map(|v| v, |force| AnyForce::Network(force.clone()));
    save_model(&path, &SavedModel { model: model.clone(), info: ModelInfo::default() }).unwrap();
    assert_eq!(load_model(&path).unwrap().model, model);
}

#[test]
fn an_unknown_name_is_said_when_the_training_begins() {
    let refused = Training::new([recording(1.0)]).with_activation("swoosh").run().unwrap_err();
    assert!(refused.to_string().contains("swoosh"), "{refused}");
}
