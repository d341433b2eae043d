//! Extended models as models without effects.

use crate::support::joint::driven;
use crate::support::published::{exact, paper_force_n, weights};
use pam_data::ModelInfo;
use pam_effects::effects::by_id;
use pam_effects::{ActiveEffect, ExtendedModel};
use pam_trajectory::{Predictor, predict};

fn extended(effects: &[(&str, &[f64])]) -> ExtendedModel {
    ExtendedModel {
        joint: weights(),
        info: ModelInfo::default(),
        effects: effects
            .iter()
            .map(|(id, values)| ActiveEffect {
                effect: by_id(id).expect("an id"),
                values: values.to_vec(),
            })
            .collect(),
    }
}

/// What is absorbed moves the joint as the effects do: an exact solver on the plain model goes where the
/// march with effects goes. Without them it goes elsewhere.
#[test]
fn the_plain_model_moves_as_the_extended_one() {
    let extended = extended(&[
        ("stiffness_scale", &[0.07]),
        ("constant_load", &[12.0]),
        ("viscous_damping", &[800.0]),
        ("added_inertia", &[35.0]),
        ("geometry_coefficient", &[0.08, 0.0]),
    ]);
    let plain = extended.without_effects();
    assert_eq!(plain.absorbed.len(), 5);
    assert!(plain.saved.info.effects.is_empty());
    let mut command = driven(6.0, 0.0, paper_force_n(0.1));
    command.pressure_flexor_kpa.fill(400.0);
    command.pressure_extensor_kpa.fill(450.0);
    let masses = extended.joint.gas_law_masses(0.0, [400.0, 450.0]);
    // Masses that belong to the recording, not to the law, are the same for both.
    command.given_masses = Some(masses);
    let with = extended.predict(&command, masses, &exact()).expect("runs");
    let same = predict(&plain.saved.model, &command, masses, &exact()).expect("runs");
    let without = predict(&extended.joint, &command, masses, &exact()).expect("runs");
    let distance =
        |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let off = distance(&with.channels.x, &same.channels.x);
    assert!(off < 2e-3, "{off} mm");
    assert!(distance(&with.channels.x, &without.channels.x) > 0.1);
}

#[test]
fn what_a_plain_model_cannot_hold_is_said() {
    let plain = extended(&[
        ("coulomb_friction", &[12.0]),
        ("pressure_delay", &[20.0]),
        ("constant_load", &[3.0]),
        ("geometry_coefficient", &[0.08, 1.0]),
    ])
    .without_effects();
    assert_eq!(plain.left_out, ["coulomb_friction", "geometry_coefficient"]);
    assert_eq!(plain.of_instruments, ["pressure_delay"]);
    assert_eq!(plain.absorbed, ["constant_load"]);
    let told = plain.sentence().expect("something to say");
    assert!(told.contains("coulomb_friction, geometry_coefficient is left out"), "{told}");
    assert!(extended(&[]).without_effects().sentence().is_none());
}
