use super::testing::{assert_cotangents, noisy, random_recording};
use num_dual::DualNum;
use pam_trajectory::loss::{SampleErrors, pointwise};
use pam_trajectory::{SquaredError, TrajectoryLoss};

#[test]
fn cotangents_are_the_derivative() {
    assert_cotangents(&pointwise(|[x, v, pf, pe]| x.cosh().ln() + v * v + (pf * pe).tanh()), 8);
}

#[test]
fn squares_are_the_squared_error() {
    let weights = [3.0, 2.0, 1.0, 0.5];
    let own = pointwise(move |e: SampleErrors| {
        let terms = e.iter().zip(weights).map(|(e, w)| *e * *e * w);
        terms.reduce(|a, b| a + b).expect("four channels")
    });
    let measured = random_recording(17, 1);
    let predicted = noisy(&measured, 2);
    let (mut a, mut b) = ([[0.0; 4]; 17], [[0.0; 4]; 17]);
    let value = own.value_and_cotangents(&measured, &predicted, &mut a);
    let known = SquaredError { weights };
    let expected = known.value_and_cotangents(&measured, &predicted, &mut b);
    assert!((value - expected).abs() < 1e-12 * expected);
    for (a, b) in a.as_flattened().iter().zip(b.as_flattened()) {
        assert!((a - b).abs() < 1e-12 * b.abs().max(1e-3));
    }
}
