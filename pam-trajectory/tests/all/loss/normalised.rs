use super::testing::{assert_cotangents, noisy, random_recording};
use approx::assert_relative_eq;
use pam_data::Channel;
use pam_trajectory::TrajectoryLoss;
use pam_trajectory::loss::Normalised;
use pam_trajectory::metrics::r2;

#[test]
fn cotangents_are_the_derivative() {
    for seed in 0..5 {
        assert_cotangents(&Normalised { weights: [3.0, 0.2, 1.0, 0.0] }, seed);
    }
}

#[test]
fn it_is_what_r2_lacks_to_one() {
    let measured = random_recording(40, 8);
    let predicted = noisy(&measured, 9);
    let weights = [1.0, 2.0, 3.0, 4.0];
    let expected: f64 = (0..4)
        .map(|i| {
            let column: Vec<f64> = predicted.iter().map(|p| p[i]).collect();
            weights[i] * (1.0 - r2(measured.channel(Channel::ALL[i]), &column))
        })
        .sum();
    let mut cotangents = vec![[0.0; 4]; 40];
    let value = Normalised { weights }.value_and_cotangents(&measured, &predicted, &mut cotangents);
    assert_relative_eq!(value, expected, max_relative = 1e-12);
}

#[test]
fn a_constant_channel_adds_nothing() {
    let mut measured = random_recording(10, 1);
    // Ten times 0.1 is not one: the mean is not exact.
    measured.displacement_mm = vec![0.1; 10];
    let predicted = noisy(&measured, 2);
    let mut cotangents = vec![[f64::NAN; 4]; 10];
    let weights = [1.0, 0.0, 0.0, 0.0];
    let loss = Normalised { weights };
    assert_eq!(loss.value_and_cotangents(&measured, &predicted, &mut cotangents), 0.0);
    assert!(cotangents.iter().all(|c| *c == [0.0; 4]));
}
