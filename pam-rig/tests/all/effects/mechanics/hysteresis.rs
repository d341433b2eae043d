use pam_rig::effects::Clock;
use pam_rig::effects::mechanics::hysteresis::EFFECT;
use pam_rig::plant::{Plant, PlantParameters};

#[test]
fn it_saturates_after_the_slip_and_remembers() {
    let mut plant = Plant::new(&PlantParameters::default(), Default::default(), &[]);
    let mut effect = (EFFECT.build)(&[20.0, 0.5]);
    let clock = Clock { time_s: 0.0, step_s: 1e-4, sealed_g: None };
    let mut at = |x: f64| {
        plant.place(x, 0.0);
        effect.joint_force_n(&clock, &plant)
    };
    assert_eq!(at(0.0), 0.0);
    assert!(at(0.45) > -20.0);
    assert!((at(0.5) + 20.0).abs() < 1e-12);
    assert!((at(3.0) + 20.0).abs() < 1e-12);
    assert!((at(2.0) - 20.0).abs() < 1e-12);
}
