use super::testing::{assert_cotangents, noisy, random_recording};
use pam_data::Recording;
use pam_trajectory::TrajectoryLoss;

/// `mean (x̂ − x)⁴`, written down on the spot.
#[test]
fn closures_are_losses() {
    let quartic = |m: &Recording, p: &[[f64; 4]], c: &mut [[f64; 4]]| {
        let scale = 1.0 / p.len() as f64;
        let mut value = 0.0;
        for ((p, c), x) in p.iter().zip(c).zip(&m.displacement_mm) {
            *c = [4.0 * scale * (p[0] - x).powi(3), 0.0, 0.0, 0.0];
            value += scale * (p[0] - x).powi(4);
        }
        value
    };
    assert_cotangents(&quartic, 5);
    let measured = random_recording(9, 1);
    let predicted = noisy(&measured, 2);
    let loss: &dyn TrajectoryLoss = &quartic;
    let value = loss.value_and_cotangents(&measured, &predicted, &mut [[0.0; 4]; 9]);
    assert!(value > 0.0);
}
