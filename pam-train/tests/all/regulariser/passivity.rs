use super::testing::{assert_gradient, joint, random_joint};
use approx::assert_relative_eq;
use pam_core::force::Dense;
use pam_train::Regulariser;
use pam_train::regulariser::{OperatingBox, Passivity, SlopeFloor};

fn passivity(damping: Option<SlopeFloor>, stiffness: Option<SlopeFloor>) -> Passivity {
    let within = OperatingBox {
        mass_flexor_g: [0.2, 1.0],
        mass_extensor_g: [-1.0, 0.5],
        displacement_mm: [-3.0, 3.0],
        velocity_mm_s: [-2.0, 2.0],
    };
    // Not a whole number of chunks.
    Passivity { within, points: 300, seed: 4, damping, stiffness }
}

fn floor(floor: f64) -> Option<SlopeFloor> {
    Some(SlopeFloor { strength: 2.0, floor, half_width: 0.25 })
}

/// f = 3x − 5ẋ: stiffness 3 everywhere, damping −5.
#[test]
fn a_linear_force_has_the_slopes_of_its_weights() {
    let model = joint(vec![Dense::from_rows(&[0.3, 0.7, 3.0, -5.0], vec![1.0]).unwrap()]);
    let value = |p: Passivity| p.value_and_gradient(&model, &mut [0.0; 5]);
    assert_relative_eq!(value(passivity(floor(0.0), None)), 50.0, max_relative = 1e-10);
    assert_relative_eq!(value(passivity(floor(-4.0), None)), 2.0, max_relative = 1e-10);
    assert_eq!(value(passivity(floor(-6.0), None)), 0.0);
    assert_eq!(value(passivity(None, floor(0.0))), 0.0);
    let both = passivity(floor(0.0), floor(4.0));
    assert_relative_eq!(value(both), 52.0, max_relative = 1e-10);
    // Only the weight of ẋ has to do with damping: ∂/∂w 2(0 − w)² = 4w.
    let mut gradient = [0.0; 5];
    passivity(floor(0.0), None).value_and_gradient(&model, &mut gradient);
    for (found, expected) in gradient.iter().zip([0.0, 0.0, 0.0, -20.0, 0.0]) {
        assert!((found - expected).abs() < 1e-9, "{gradient:?}");
    }
}

#[test]
fn gradient_is_the_derivative() {
    for seed in 0..3 {
        let model = random_joint(&[4, 7, 5, 1], seed);
        assert_gradient(&passivity(floor(0.1), None), &model);
        assert_gradient(&passivity(None, floor(0.2)), &model);
        assert_gradient(&passivity(floor(0.0), floor(-0.1)), &model);
    }
}
