use super::testing::{assert_cotangents, constant_recording};
use pam_trajectory::SquaredError;
use pam_trajectory::TrajectoryLoss;

#[test]
fn cotangents_are_the_derivative() {
    for seed in 0..5 {
        assert_cotangents(&SquaredError { weights: [3.0, 0.2, 1.0, 0.0] }, seed);
    }
}

/// Errors 1, 2, 3, 4 in every sample: 100·(1 + 4) + (9 + 16) as the paper writes it.
#[test]
fn known_errors_have_the_value_of_the_formula() {
    let measured = constant_recording(7, [0.0, 0.0, 200.0, 200.0]);
    let predicted = [[1.0, -2.0, 203.0, 196.0]; 7];
    let value = |loss: SquaredError| {
        loss.value_and_cotangents(&measured, &predicted, &mut [[f64::NAN; 4]; 7])
    };
    assert!((value(SquaredError::paper()) - 525.0).abs() < 1e-10);
    assert!((value(SquaredError::published()) - 262.5).abs() < 1e-10);
}
