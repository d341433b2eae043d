use super::testing::{assert_gradient, joint, random_joint};
use pam_core::force::Dense;
use pam_train::Regulariser;
use pam_train::regulariser::L2;

/// Weights 1, 2, 3, 4 | 5 and biases that do not count: 0.1 · 55.
#[test]
fn it_is_the_sum_of_squares_without_biases() {
    let model = joint(vec![
        Dense::from_rows(&[1.0, 2.0, 3.0, 4.0], vec![100.0]).unwrap(),
        Dense::from_rows(&[5.0], vec![200.0]).unwrap(),
    ]);
    let mut gradient = vec![1.0; 7];
    let value = L2 { strength: 0.1 }.value_and_gradient(&model, &mut gradient);
    assert!((value - 5.5).abs() < 1e-14);
    // Added to the ones that were there; 2 · 0.1 · w for weights, nothing for biases.
    for (found, expected) in gradient.iter().zip([1.2, 1.4, 1.6, 1.8, 1.0, 2.0, 1.0]) {
        assert!((found - expected).abs() < 1e-14, "{gradient:?}");
    }
}

#[test]
fn gradient_is_the_derivative() {
    assert_gradient(&L2 { strength: 0.3 }, &random_joint(&[4, 6, 5, 1], 2));
}
