use pam_rig::plant::DryFriction;
use pam_rig::plant::friction::after_friction;

#[test]
fn below_the_threshold_nothing_moves_and_above_the_excess_does() {
    assert_eq!(after_friction(0.0, 0.9, 1.0, 1.0), 0.0);
    assert_eq!(after_friction(0.0, -1.5, 1.0, 1.0), -0.5);
    assert_eq!(after_friction(0.0, -1.5, 1.0, 2.0), 0.0);
    assert_eq!(after_friction(2.0, 0.5, 1.0, 1.0), 1.5);
    assert_eq!(after_friction(-2.0, -0.5, 1.0, 1.0), -1.5);
    assert_eq!(after_friction(-2.0, 3.0, 0.0, 0.0), 1.0);
}

#[test]
fn a_joint_that_stops_within_the_step_sticks_or_turns_with_the_rest_of_it() {
    // Stops by friction alone and stays.
    assert_eq!(after_friction(0.5, 0.0, 1.0, 1.0), 0.0);
    // Stops after half of the step; the force exceeds the friction by 1 for the other half.
    assert_eq!(after_friction(2.0, -3.0, 1.0, 1.0), -1.0);
    assert_eq!(after_friction(2.0, -3.0, 1.0, 4.0), 0.0);
    assert_eq!(after_friction(-2.0, 3.0, 1.0, 1.0), 1.0);
}

#[test]
fn stribeck_falls_from_static_to_coulomb() {
    let f = DryFriction { coulomb_n: 10.0, static_n: 16.0, velocity_mm_s: 2.0 };
    assert_eq!(f.limit_n(0.0), 16.0);
    assert!((f.limit_n(2.0) - (10.0 + 6.0 / std::f64::consts::E)).abs() < 1e-12);
    assert!((f.limit_n(50.0) - 10.0).abs() < 1e-12);
}
