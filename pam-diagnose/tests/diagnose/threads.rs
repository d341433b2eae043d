//! The same seed gives the same answer.

use crate::support::joint::{HOLD, driven, linear, subject};
use pam_data::Subject;
use pam_data::{MassOrigin, ModelInfo};
use pam_diagnose::{DiagnoseOptions, RecordingSets, diagnose};
use pam_effects::effects::by_id;
use pam_effects::{ActiveEffect, ExtendedModel};
use pam_trajectory::{Predictor, SolverSettings};
use std::f64::consts::TAU;

fn data(model: &ExtendedModel) -> Vec<Subject> {
    let effect = by_id("coulomb_friction").expect("an id");
    let plant = model.with([ActiveEffect { effect, values: vec![14.0] }]);
    [(0.5, 90.0), (1.0, 120.0), (0.7, 60.0)]
        .iter()
        .map(|&(hertz, newton)| {
            let command = driven(8.0, 0.0, |t| newton * (TAU * hertz * (t + HOLD)).sin());
            let mut s = subject(&model.joint, command, MassOrigin::Given);
            let run = plant.predict(&s.recording, s.masses, &SolverSettings::default());
            s.recording = run.expect("in range").to_recording(&s.recording, s.masses);
            // Noise of a fixed pattern.
            for (k, x) in s.recording.displacement_mm.iter_mut().enumerate() {
                *x += 0.003 * (1e4 * (k as f64 * 12.9898).sin()).fract();
            }
            s
        })
        .collect()
}

#[test]
fn a_diagnosis_does_not_depend_on_the_number_of_threads() {
    let model = ExtendedModel { joint: linear(), info: ModelInfo::default(), effects: Vec::new() };
    let data = data(&model);
    let ids = ["coulomb_friction", "hysteresis", "creep", "stiffness_scale", "pressure_sensor_lag"];
    let options = DiagnoseOptions {
        candidates: ids.iter().filter_map(|id| by_id(id)).collect(),
        seed: 5,
        law: false,
        ..DiagnoseOptions::default()
    };
    let sets = RecordingSets { data: &data, test: None, baseline: None };
    let answers = [1, 2, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let found = pool.install(|| diagnose(&model, &sets, &options, &|_, _| {}));
        found.expect("a diagnosis").to_json("model.safetensors").to_string()
    });
    assert!(answers[0].contains("\"effect\":\"coulomb_friction\""), "{}", answers[0]);
    assert_eq!(answers[0], answers[1]);
    assert_eq!(answers[1], answers[2]);
}
