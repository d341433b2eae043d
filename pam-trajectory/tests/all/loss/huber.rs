use super::testing::{assert_cotangents, constant_recording, noisy, random_recording};
use approx::assert_relative_eq;
use pam_trajectory::loss::{Huber, HuberForm};
use pam_trajectory::{SquaredError, TrajectoryLoss};

fn huber(form: HuberForm, threshold: f64) -> Huber {
    Huber { form, thresholds: [threshold; 4], weights: [1.0, 2.0, 3.0, 0.5] }
}

const FORMS: [HuberForm; 2] = [HuberForm::Huber, HuberForm::PseudoHuber];

#[test]
fn cotangents_are_the_derivative() {
    for form in FORMS {
        for seed in 0..5 {
            // Errors reach three: both branches are met.
            assert_cotangents(&huber(form, 1.0), seed);
        }
    }
}

/// Huber (1964): e²/2 up to δ, δ(|e| − δ/2) beyond; here with δ = 2 and twice as much.
#[test]
fn known_errors_have_the_value_of_the_formula() {
    let measured = constant_recording(1, [0.0, 0.0, 200.0, 200.0]);
    let predicted = [[1.0, -3.0, 205.0, 200.0]];
    let value =
        huber(HuberForm::Huber, 2.0).value_and_cotangents(&measured, &predicted, &mut [[0.0; 4]]);
    assert_relative_eq!(value, 1.0 + 2.0 * 8.0 + 3.0 * 16.0, max_relative = 1e-14);
    let value = huber(HuberForm::PseudoHuber, 2.0).value_and_cotangents(
        &measured,
        &predicted,
        &mut [[0.0; 4]],
    );
    let smooth = |e: f64| 8.0 * ((1.0 + e * e / 4.0).sqrt() - 1.0);
    let expected = smooth(1.0) + 2.0 * smooth(3.0) + 3.0 * smooth(5.0);
    assert_relative_eq!(value, expected, max_relative = 1e-14);
}

#[test]
fn far_below_the_threshold_it_is_the_squared_error() {
    let measured = random_recording(30, 5);
    let predicted = noisy(&measured, 6);
    let evaluate = |loss: &dyn TrajectoryLoss| {
        let mut cotangents = vec![[0.0; 4]; 30];
        (loss.value_and_cotangents(&measured, &predicted, &mut cotangents), cotangents)
    };
    let squared = evaluate(&SquaredError { weights: [1.0, 2.0, 3.0, 0.5] });
    assert_eq!(evaluate(&huber(HuberForm::Huber, 1e3)), squared);
    let smooth = evaluate(&huber(HuberForm::PseudoHuber, 1e6));
    assert_relative_eq!(smooth.0, squared.0, max_relative = 1e-10);
}
