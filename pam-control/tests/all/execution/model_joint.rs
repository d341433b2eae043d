use pam_control::execution::{Commands, ModelJoint, Pulse, PulseShape, perturb};
use pam_control::identification::{Response, identify};
use pam_core::{JointModel, SpringDamper};
use std::sync::Arc;

/// A spring and damper of known size is identified as such, and rests where its commands say.
#[test]
fn a_pulse_gives_back_the_models_own_numbers() {
    let spring = SpringDamper::constant(150e3, 6500.0);
    let model = Arc::new(JointModel::datasheet(spring));
    let mass_kg = model.physical().mass_kg;
    let mut joint = ModelJoint::new(model, [400.0; 2]);
    let commands = Commands {
        step_s: 0.5,
        displacement_mm: vec![0.0; 3],
        stiffness_n_mm: vec![150.0; 3],
        pressures_kpa: vec![[400.0; 2]; 3],
    };
    let pulse = Pulse { time_s: 0.2, direction: 1.0, place: "rest" };
    let records = perturb(&mut joint, &commands, 0.1, &[pulse], &PulseShape::default());
    let found = identify(&Response::of_pulse(&records[0], mass_kg)).unwrap();
    assert!((found.stiffness_n_mm - 150.0).abs() < 1e-3, "{found:?}");
    assert!((found.damping_kg_s - 6500.0).abs() < 0.1, "{found:?}");
}
