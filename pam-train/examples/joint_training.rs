//! Weights and effects trained together: a network that was fitted before the joint wore, and recordings of the
//! worn joint.

use pam_data::{Recording, load_model, subjects};
use pam_effects::effects::by_id;
use pam_effects::{ActiveEffect, ExtendedModel};
use pam_train::curriculum::Curriculum;
use pam_train::training::Trainer;
use pam_trajectory::{AnyLoss, Predictor, SolverSettings};
use std::f64::consts::TAU;
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../pam-cli/models/default.safetensors");
    let model = ExtendedModel::from_saved(load_model(&file)?)?;
    let masses = model.joint.gas_law_masses(0.0, [412.0, 412.0]); // kPa absolute, sealed at x = 0
    let friction = by_id("coulomb_friction").expect("an effect of the vocabulary");

    // The worn joint: the model with 18 N of dry friction.
    let worn = model.with([ActiveEffect { effect: friction, values: vec![18.0] }]);
    let mut data = Vec::new();
    for (hz, newton) in [(0.5, 120.0), (1.0, 160.0)] {
        let time_s: Vec<f64> = (0..2000).map(|k| 2e-3 * f64::from(k)).collect();
        let command = Recording::at_rest("worn", time_s, [412.0, 412.0])
            .with_force(|t| 1e3 * newton * (TAU * hz * t).sin());
        let run = worn.predict(&command, masses, &SolverSettings::default())?;
        data.push(run.to_recording(&command, masses));
    }

    // The gradient by everything at once, where the friction is thought to be 5 N.
    let believed = vec![ActiveEffect { effect: friction, values: vec![5.0] }];
    let subjects = subjects(data.clone(), &model.joint)?;
    let gradient =
        model.with(believed.clone()).value_and_gradient(&subjects, &AnyLoss::default())?;
    println!("dL/d force_n = {:.3}, {} weights", gradient.effects[0], gradient.force.len());
    assert!(gradient.effects[0] < 0.0); // more friction, less loss

    // Training them together, the friction fast enough that the network does not imitate it first.
    let start = format!("model.start={{ file = {:?} }}", file.display().to_string());
    let curriculum = Curriculum::open("joint", &[start, "coordinates.effect_rate=300".into()])?;
    let mut trainer = Trainer::extended(curriculum, data, None, believed, 1)?;
    while trainer.advance()?.is_some() {}
    let force_n = trainer.effect_values()[0].1;
    println!("friction {force_n:.2} N");
    assert!((force_n / 18.0 - 1.0).abs() < 0.1);
    Ok(())
}
